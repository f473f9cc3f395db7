/* Records of a page that outlive it, in the browser's database. They are encrypted by a key that follows from that of the
 * page: after the end of the server another program may listen at its port, and could read them. */

import { storageKey } from "app/proof.js";

// Records of a page that has written nothing for this time are deleted: nobody loads it again.
const KEPT_MS = 7 * 86_400_000;
const IV_BYTES = 12;

/** Returns a promise of the result of a request of the database. @returns {Promise<any>} */
function answer(request) {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}

export class Store {
  constructor(database, key, page) {
    this.database = database;
    this.key = key;
    this.page = page;
  }

  /** Opens the records of a page whose data attribute has the `digits` of a key. */
  static async open(page, digits) {
    const request = indexedDB.open("warpvec", 1);
    request.onupgradeneeded = () => ["pages", "records"].forEach((name) => request.result.createObjectStore(name));
    const store = new Store(await answer(request), await storageKey(digits), page);
    await store.deleteOld();
    return store;
  }

  async deleteOld() {
    const work = this.database.transaction(["pages", "records"], "readwrite");
    const pages = work.objectStore("pages");
    const [names, times] = await Promise.all([answer(pages.getAllKeys()), answer(pages.getAll())]);
    for (const [i, page] of names.entries()) {
      if (page === this.page || Date.now() - times[i] < KEPT_MS) continue;
      pages.delete(page);
      work.objectStore("records").delete(rangeOf(page));
    }
  }

  /** Copies the records of another page. */
  async copyFrom(page) {
    const work = this.database.transaction(["pages", "records"], "readwrite");
    const records = work.objectStore("records");
    const [keys, values] = await Promise.all([answer(records.getAllKeys(rangeOf(page))), answer(records.getAll(rangeOf(page)))]);
    keys.forEach(([, name], i) => records.put(values[i], [this.page, name]));
    work.objectStore("pages").put(Date.now(), this.page);
  }

  /** Returns the bytes of each record by its name; those that another key has encrypted are missing. */
  async read() {
    const records = this.database.transaction("records").objectStore("records");
    const [keys, values] = await Promise.all([answer(records.getAllKeys(rangeOf(this.page))), answer(records.getAll(rangeOf(this.page)))]);
    const texts = values.map(({ iv, data }) => crypto.subtle.decrypt({ name: "AES-GCM", iv }, this.key, data).catch(() => null));
    const found = (await Promise.all(texts)).map((data, i) => /** @type {[string, any]} */ ([keys[i][1], data]));
    return new Map(found.filter(([, data]) => data));
  }

  /** Writes records by their names, or deletes those that are null; all, or none if an error is thrown. */
  async write(changes) {
    const encrypted = await Promise.all([...changes].map(async ([name, bytes]) => [name, bytes && (await this.encrypted(bytes))]));
    const work = this.database.transaction(["pages", "records"], "readwrite");
    const end = new Promise((resolve, reject) => {
      work.oncomplete = resolve;
      work.onabort = () => reject(work.error);
    });
    const records = work.objectStore("records");
    for (const [name, record] of encrypted) record ? records.put(record, [this.page, name]) : records.delete([this.page, name]);
    work.objectStore("pages").put(Date.now(), this.page);
    await end;
  }

  async encrypted(bytes) {
    const iv = crypto.getRandomValues(new Uint8Array(IV_BYTES));
    return { iv, data: await crypto.subtle.encrypt({ name: "AES-GCM", iv }, this.key, bytes) };
  }
}

function rangeOf(page) {
  return IDBKeyRange.bound([page], [page, []]);
}
