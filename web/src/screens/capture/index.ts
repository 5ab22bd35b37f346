export { additions, dialOf } from "./asked";
export { CaptureScreen } from "./screen";
