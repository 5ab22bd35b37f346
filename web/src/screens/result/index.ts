export { ResultScreen } from "./screen";
