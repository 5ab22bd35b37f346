/** The limb with its measures: which shape, how far apart the levels lie, which of them is shown. */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";

import { type Schemas, answerOf, api, bytesOf } from "../../api/client";
import figures from "../../api/figures.json";
import { cut, heightsOf } from "../../geometry/section";
import { useQuery } from "../../state/requests";
import { useLimb } from "../limb";
import type { OpenCase } from "../open-case";
import { pairsOf } from "./lengths";
import { saveAs } from "./save-as";

/** Of the rows, counted from the top: shown at first. */
const FIRST_ROW = 4;
/** So near to a row, a level is that row. */
const AT_ROW_MM = 0.05;

const XLSX = "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet";

export type Measured = ReturnType<typeof useMeasured>;

export function useMeasured(openCase: OpenCase) {
  const of = useSignal<"scan" | "rectified">("scan");
  const spacing = useSignal(figures.LEVEL_SPACING_MM);
  const sock = useSignal(0);
  const level = useSignal<number | null>(null);
  const { limb, asked } = useLimb(openCase, of.value);
  const aligned = limb?.reply.aligned ?? false;
  const body = (): Schemas["AskMeasures"] => ({
    of: of.value,
    spacing_mm: spacing.value,
    sock_mm: sock.value || null,
    volumes: [],
    lengths: pairsOf(limb?.reply),
    tapes: [],
    along: false,
    inside: false,
    unaligned: false,
    sheet: false,
    shoe_heel_mm: 0,
    shoe_sole_mm: 0,
    with_tape: true,
  });
  const measures = useQuery(async () => {
    const asks = body();
    return aligned
      ? { ...(await answerOf(api.POST("/api/v1/cases/{case_id}/measures", { params: { path: { case_id: openCase.id } }, body: asks }))), of: asks.of }
      : null;
  }, [openCase.id, aligned, openCase.changes.work, of.value, spacing.value, sock.value]);
  /** Of the shape that is chosen, and of no other one while that is asked for. */
  const found = measures.value.value?.of === of.value ? measures.value.value : null;
  const heights = useMemo(() => (limb ? heightsOf(limb.fetched.data.positions, limb.frame) : null), [limb]);
  const rows = useMemo(() => [...(found?.levels ?? [])].reverse(), [found]);
  useEffect(() => {
    if (level.value === null && rows.length) level.value = rows[Math.min(FIRST_ROW, rows.length - 1)].height_mm;
  }, [rows]);
  const here = useMemo(
    () => (limb && heights && level.value !== null ? cut(limb.fetched.data.positions, limb.fetched.data.indices, heights, level.value, limb.frame) : null),
    [limb, heights, level.value],
  );
  /** The row of this very height: its figures are the server's, which know what fine relief the surface lost. */
  const row = rows.find((one) => level.value !== null && Math.abs(one.height_mm - level.value) < AT_ROW_MM);
  /** The tables for a spreadsheet, as a file of the person's. */
  const sheet = async () => {
    const { bytes } = await bytesOf(`/cases/${openCase.id}/measures.xlsx`, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(body()),
    });
    saveAs(new Blob([bytes], { type: XLSX }), `${openCase.id}-measures.xlsx`);
  };
  return { of, spacing, sock, level, limb, asked, aligned, measures, found, rows, row, here, from: found?.reference_height_mm ?? 0, sheet };
}
