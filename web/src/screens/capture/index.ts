export { additions, dialOf } from "./additions";
export { CaptureScreen } from "./screen";
