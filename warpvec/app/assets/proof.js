/* The server must prove that it knows the key of this page, before the page tells it anything: after the end of the
 * server another program may listen at its port. See app/identity.py. */

const TOKEN_DIGITS = 32;

/** Thrown if another program answers, or a server with another key. */
export class WrongServer extends Error {}

const fromHex = (digits) => Uint8Array.from(digits.match(/../g) ?? [], (pair) => parseInt(pair, 16));
const toHex = (buffer) => [...new Uint8Array(buffer)].map((byte) => byte.toString(16).padStart(2, "0")).join("");
const encoded = (text) => new TextEncoder().encode(text);

async function signingKey(digits) {
  return crypto.subtle.importKey("raw", fromHex(digits), { name: "HMAC", hash: "SHA-256" }, false, ["sign", "verify"]);
}

/** Returns the key of what pages of this server keep in the browser. */
export async function storageKey(digits) {
  const bytes = await crypto.subtle.sign("HMAC", await signingKey(digits), encoded("storage"));
  return crypto.subtle.importKey("raw", bytes, "AES-GCM", false, ["encrypt", "decrypt"]);
}

/** Returns the path below which the server with this key answers, "/TOKEN/", once it has proved itself. */
export async function provenPath(digits) {
  const nonce = toHex(crypto.getRandomValues(new Uint8Array(16)));
  const answer = await fetch(`/proof?nonce=${nonce}`, { redirect: "error" });
  const { start = "", proof = "" } = await answer.json().catch(() => ({}));
  const key = await signingKey(digits);
  const isGood = await crypto.subtle.verify("HMAC", key, fromHex(String(proof)), encoded(`proof ${location.host} ${nonce} ${start}`));
  if (!isGood) throw new WrongServer();
  return `/${toHex(await crypto.subtle.sign("HMAC", key, encoded(`token ${start}`))).slice(0, TOKEN_DIGITS)}/`;
}
