/* Writes a graph of plain objects as text, and reads it again. What is one object in several places stays one, which
 * undo needs. Of other objects only lists, maps, sets and lists of numbers are known; the rest, such as a Path2D, becomes
 * null, as it can be made again. */

import { keepStatedId, statedIdOf } from "viewer/gradients.js";

/** Returns the text of `root`.
 *
 * @param {any} root
 * @param {Map<any, any>} stands objects, and those whose content is written in their place */
export function pack(root, stands = new Map()) {
  const places = new Map();
  const found = [];
  const put = (value) => {
    if (value === undefined) return ["undefined"];
    if (typeof value === "number" && !Number.isFinite(value)) return [String(value)];
    if (typeof value !== "object" || value === null) return value;
    if (!places.has(value)) places.set(value, found.push(value) - 1);
    return [places.get(value)];
  };
  const first = put(root);
  const nodes = [];
  for (let i = 0; i < found.length; i++) nodes.push(nodeOf(stands.get(found[i]) ?? found[i], put));
  return JSON.stringify({ first, nodes });
}

function nodeOf(value, put) {
  if (Array.isArray(value)) return { list: value.map(put) };
  if (value instanceof Float64Array) return { numbers: [...value] };
  if (value instanceof Map) return { map: [...value].map((pair) => pair.map(put)) };
  if (value instanceof Set) return { set: [...value].map(put) };
  if (Object.getPrototypeOf(value) !== Object.prototype) return null;
  const facts = Object.entries(value).filter(([, each]) => typeof each !== "function");
  return { facts: facts.map(([name, each]) => [name, put(each)]), id: statedIdOf(value) };
}

/** Returns the graph of a text of `pack`. */
export function unpack(text) {
  const { first, nodes } = JSON.parse(text);
  const made = nodes.map(emptyOf);
  const take = (value) => {
    if (!Array.isArray(value)) return value;
    const [place] = value;
    return typeof place === "number" ? made[place] : place === "undefined" ? undefined : Number(place);
  };
  nodes.forEach((node, i) => fill(made[i], node, take));
  return take(first);
}

function emptyOf(node) {
  if (!node) return null;
  if (node.list) return [];
  if (node.numbers) return Float64Array.from(node.numbers);
  if (node.map) return new Map();
  return node.set ? new Set() : {};
}

function fill(made, node, take) {
  if (node?.list) for (const each of node.list) made.push(take(each));
  if (node?.map) for (const [key, each] of node.map) made.set(take(key), take(each));
  if (node?.set) for (const each of node.set) made.add(take(each));
  if (!node?.facts) return;
  for (const [name, each] of node.facts) made[name] = take(each);
  if (node.id) keepStatedId(made, node.id);
}
