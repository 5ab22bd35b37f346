/** The case that is open, as each of its screens is given it. */
import type { Schemas } from "../api/client";

export interface OpenCase {
  readonly id: string;
  readonly info: Schemas["Case"];
  /** How often each subject changed since the page was opened: photos, check, job, work, case. */
  readonly changes: Readonly<Record<string, number>>;
  readonly again: () => Promise<void>;
}

export interface CaseProps {
  readonly openCase: OpenCase;
}
