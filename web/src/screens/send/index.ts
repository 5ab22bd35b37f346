export { madeOf } from "./made-of";
export { SendScreen } from "./screen";
