/** The screens with the canvas, in one file that is loaded when the first of them is opened. */
export { AlignScreen } from "./align";
export { CompareScreen } from "./compare";
export { MeasureScreen } from "./measure";
export { RecordScreen } from "./record";
export { RectifyScreen } from "./rectify";
export { ResultScreen } from "./result";
export { SendScreen } from "./send";
