export { AlignScreen } from "./screen";
