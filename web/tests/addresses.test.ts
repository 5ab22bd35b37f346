import { expect, test } from "vitest";

import description from "../openapi.json";

const sources = Object.values(import.meta.glob<string>(["../src/**/*.{ts,tsx}", "!../src/api/schema.ts"], { query: "?raw", import: "default", eager: true }));
const routes = Object.keys(description.paths);
const isRoute = (address: string) => routes.some((one) => new RegExp(`^${one.replace(/\{[^}]*\}/g, "[^/]+")}$`).test(address));

/** Addresses that are put together by hand, each value in them as one letter; typed calls prove theirs. */
const addresses = (text: string): string[] =>
  [...text.matchAll(/`(?:\$\{ROOT\}|\/api\/v1)(\/[^`]*)`/g)]
    .map(([, path]) => `/api/v1${path.replace(/\$\{(?:[^{}]|\{[^{}]*\})*\}/g, "x").split("?")[0]}`)
    .filter((one) => !one.includes("{"));

test("each address that the client puts together is one of the server's", () => {
  const found = sources.flatMap(addresses);
  expect(found.length).toBeGreaterThan(8);
  expect(found.filter((one) => !isRoute(one))).toEqual([]);
});
