import { expect, test } from "vitest";

import { changedBy, decodeBlocks, surfaceOf } from "../src/api/blocks";

/** As the server writes it. */
function encode(header: Record<string, unknown>, blocks: Record<string, Float32Array | Uint32Array | Uint8Array>): ArrayBuffer {
  const listed: object[] = [];
  let offset = 0;
  const parts: Uint8Array[] = [];
  for (const [name, array] of Object.entries(blocks)) {
    const type = array instanceof Float32Array ? "float32" : array instanceof Uint32Array ? "uint32" : "uint8";
    listed.push({ name, type, shape: [array.length], offset, bytes: array.byteLength });
    const padded = new Uint8Array(array.byteLength + ((4 - (array.byteLength % 4)) % 4));
    padded.set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    parts.push(padded);
    offset += padded.length;
  }
  let text = JSON.stringify({ ...header, blocks: listed });
  text += " ".repeat((4 - (text.length % 4)) % 4);
  const made = new Uint8Array(8 + text.length + offset);
  made.set([0x4c, 0x47, 0x4d, 0x31]);
  new DataView(made.buffer).setUint32(4, text.length, true);
  made.set(new TextEncoder().encode(text), 8);
  let at = 8 + text.length;
  for (const part of parts) {
    made.set(part, at);
    at += part.length;
  }
  return made.buffer;
}

const WHOLE = encode(
  { what: "surface" },
  {
    positions: Float32Array.from([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0]),
    indices: Uint32Array.from([0, 1, 2, 1, 3, 2]),
    sigma: Float32Array.from([0.1, 0.2, NaN, 0.4]),
    flags: Uint8Array.from([0, 0, 1, 0]),
  },
);

test("a surface comes as it was sent", () => {
  const surface = surfaceOf(decodeBlocks(WHOLE));
  expect([...surface.indices]).toEqual([0, 1, 2, 1, 3, 2]);
  expect(surface.positions[9]).toBe(1);
  expect(surface.sigma?.[2]).toBeNaN();
  expect([...(surface.filled ?? [])]).toEqual([0, 0, 1, 0]);
  expect(surface.colours).toBeNull();
});

test("a change moves what it names, adds what is new, and leaves the rest", () => {
  const before = surfaceOf(decodeBlocks(WHOLE));
  const change = encode(
    { what: "change", vertices: 5, faces: 3 },
    {
      changed: Uint32Array.from([3, 4]),
      positions: Float32Array.from([1, 1, -2, 2, 2, 0]),
      faces_changed: Uint32Array.from([2]),
      indices: Uint32Array.from([3, 4, 2]),
      sigma: Float32Array.from([0.4, 0.5]),
      flags: Uint8Array.from([0, 0]),
    },
  );
  const after = changedBy(before, decodeBlocks(change));
  expect([...after.positions.slice(0, 9)]).toEqual([...before.positions.slice(0, 9)]);
  expect([...after.positions.slice(9)]).toEqual([1, 1, -2, 2, 2, 0]);
  expect([...after.indices.slice(6)]).toEqual([3, 4, 2]);
  expect(after.sigma?.[4]).toBeCloseTo(0.5, 6);
  expect(before.positions[11]).toBe(0);
});

test("what is no surface is refused", () => {
  expect(() => decodeBlocks(new ArrayBuffer(16))).toThrow("not a surface");
});
