export { openWith } from "./drawing";
export { RectifyScreen } from "./screen";
