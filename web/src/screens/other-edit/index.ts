export { OtherEdit } from "./form";
export { choicesOf, rangeOf, valueOf } from "./values";
