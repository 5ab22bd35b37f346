export { CasesScreen } from "./screen";
export { inShort, withoutColour } from "./in-short";
