export { MeasureScreen } from "./screen";
