import { expect, test } from "vitest";

import { judged, withPending } from "../src/screens/readings";

const act = (height_mm: number, girth_mm: number | null) => ({ init: { body: { height_mm, girth_mm } } });

test("readings on their way stand over what the server keeps, the last one of a height counts", () => {
  const kept = [
    { height_mm: 100, girth_mm: 300 },
    { height_mm: 120, girth_mm: 310 },
  ];
  expect(withPending(kept, [act(80, 290), act(100, 301), act(120, null), act(100.004, 302)])).toEqual([
    { height_mm: 80, girth_mm: 290 },
    { height_mm: 100.004, girth_mm: 302 },
  ]);
  expect(withPending(kept, [])).toEqual(kept);
});

test("what was said of one girth is not said of another", () => {
  const said = [{ height_mm: 100, girth_mm: 300, conflict: false, accepted: "", difference_mm: 0.2, reason: null }];
  expect(judged([{ height_mm: 100, girth_mm: 300 }], said)[0].verdict?.conflict).toBe(false);
  expect(judged([{ height_mm: 100, girth_mm: 350 }], said)[0].verdict).toBeNull();
  expect(judged([{ height_mm: 120, girth_mm: 300 }], said)[0].verdict).toBeNull();
});
