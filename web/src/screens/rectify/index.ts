export { openWith } from "./hand";
export { RectifyScreen } from "./screen";
