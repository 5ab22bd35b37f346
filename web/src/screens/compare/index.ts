export { CompareScreen } from "./screen";
