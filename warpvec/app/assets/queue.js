/* The list of pictures: which one is shown, how far each is, and buttons to open and remove them. */

export class PictureList {
  constructor(list, onOpen, onRemove) {
    this.list = list;
    this.onOpen = onOpen;
    this.onRemove = onRemove;
    this.rows = new Map();
  }

  show(pictures, current) {
    for (const [picture, row] of this.rows) {
      if (pictures.includes(picture)) continue;
      row.item.remove();
      this.rows.delete(picture);
    }
    for (const picture of pictures) {
      const row = this.rows.get(picture) ?? this.add(picture);
      row.state.textContent = picture.state;
      row.open.setAttribute("aria-current", String(picture === current));
    }
  }

  add(picture) {
    const item = document.createElement("li");
    const open = document.createElement("button");
    Object.assign(open, { className: "open", textContent: picture.name, title: picture.name });
    open.addEventListener("click", () => this.onOpen(picture));
    const state = document.createElement("span");
    state.className = "state";
    const remove = document.createElement("button");
    Object.assign(remove, { textContent: "×", title: "Remove from the list" });
    remove.setAttribute("aria-label", `Remove ${picture.name}`);
    remove.addEventListener("click", () => this.onRemove(picture));
    item.append(open, state, remove);
    this.list.append(item);
    const row = { item, open, state };
    this.rows.set(picture, row);
    return row;
  }
}
