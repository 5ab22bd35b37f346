/**
 * Arrays in one binary answer of the server: LGM1, the header's length, the header, the blocks.
 *
 * A block begins at a multiple of four, so a view is laid over the answer without a copy.
 */
import type { SurfaceData } from "../viewer/surface";

interface Listed {
  readonly name: string;
  readonly type: "float32" | "uint32" | "uint8";
  readonly shape: readonly number[];
  readonly offset: number;
  readonly bytes: number;
}

export type Block = Float32Array | Uint32Array | Uint8Array;

export interface Blocks {
  readonly header: Readonly<Record<string, unknown>>;
  readonly blocks: ReadonlyMap<string, Block>;
}

const VIEWS = { float32: Float32Array, uint32: Uint32Array, uint8: Uint8Array } as const;

export function decodeBlocks(answer: ArrayBuffer): Blocks {
  const view = new DataView(answer);
  if (answer.byteLength < 8 || view.getUint32(0, false) !== 0x4c474d31) throw new Error("The answer is not a surface.");
  const start = 8 + view.getUint32(4, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(answer, 8, start - 8))) as { blocks: Listed[] } & Record<string, unknown>;
  const blocks = new Map<string, Block>();
  for (const one of header.blocks) {
    const kind = VIEWS[one.type];
    blocks.set(one.name, new kind(answer, start + one.offset, one.bytes / kind.BYTES_PER_ELEMENT));
  }
  return { header, blocks };
}

const floats = (b: Block | undefined) => (b instanceof Float32Array ? b : null);
const whole = (b: Block | undefined) => (b instanceof Uint32Array ? b : null);
const small = (b: Block | undefined) => (b instanceof Uint8Array ? b : null);

export function surfaceOf({ blocks }: Blocks): SurfaceData {
  const flags = small(blocks.get("flags"));
  return {
    positions: floats(blocks.get("positions")) ?? new Float32Array(),
    indices: whole(blocks.get("indices")) ?? new Uint32Array(),
    sigma: floats(blocks.get("sigma")),
    colours: small(blocks.get("colours")),
    filled: flags ? flags.map((flag) => flag & 1) : null,
  };
}

/** The surface after a change that the server sent: what it did not name stays. */
export function changedBy(before: SurfaceData, change: Blocks): SurfaceData {
  if (change.header.what !== "change") return surfaceOf(change);
  const vertices = Number(change.header.vertices);
  const faces = Number(change.header.faces);
  const at = whole(change.blocks.get("changed")) ?? new Uint32Array();
  const which = whole(change.blocks.get("faces_changed")) ?? new Uint32Array();
  const put = <A extends Block>(old: A | null, next: A | null, per: number, where: Uint32Array, count: number, make: (n: number) => A): A | null => {
    if (!old) return null;
    const made = make(per * count);
    made.set(old.subarray(0, per * count) as never);
    if (next) for (let i = 0; i < where.length; i++) for (let k = 0; k < per; k++) made[per * where[i] + k] = next[per * i + k];
    return made;
  };
  const f32 = (n: number) => new Float32Array(n);
  const u32 = (n: number) => new Uint32Array(n);
  const u8 = (n: number) => new Uint8Array(n);
  const b = change.blocks;
  const flags = small(b.get("flags"));
  return {
    positions: put(before.positions, floats(b.get("positions")), 3, at, vertices, f32) ?? before.positions,
    indices: put(before.indices, whole(b.get("indices")), 3, which, faces, u32) ?? before.indices,
    sigma: put(before.sigma, floats(b.get("sigma")), 1, at, vertices, f32),
    colours: put(before.colours, small(b.get("colours")), 3, at, vertices, u8),
    filled: put(before.filled, flags ? flags.map((flag) => flag & 1) : null, 1, at, vertices, u8),
  };
}
