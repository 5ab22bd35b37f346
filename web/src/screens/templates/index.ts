export { TemplateEdits } from "./screen";
