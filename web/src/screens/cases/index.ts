export { CasesScreen } from "./screen";
export { inShort, sizeUnchecked, withoutColour } from "./in-short";
