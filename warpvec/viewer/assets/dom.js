/* The elements of the page by their identifiers: texts, values and what happens when they are used. */

/** Returns the element of an identifier.
 *
 * @param {string} id
 * @returns {any} of the kind that the document has there
 */
export function find(id) {
  return document.getElementById(id);
}

/** Returns the elements of a selector.
 *
 * @param {string} selector
 * @returns {any[]}
 */
export function findAll(selector) {
  return [...document.querySelectorAll(selector)];
}

/** Returns the radio buttons or other controls of a name.
 *
 * @param {string} name
 * @returns {any[]}
 */
export function findNamed(name) {
  return [...document.getElementsByName(name)];
}

export function onInput(id, action) {
  find(id).addEventListener("input", () => action(find(id).value));
}

export function onPick(name, action) {
  for (const input of findNamed(name)) input.addEventListener("change", () => action(input.value));
}

export function connectClicks(actions) {
  for (const [id, action] of Object.entries(actions)) find(id).addEventListener("click", action);
}

export function setChoice(name, value) {
  for (const input of findNamed(name)) input.checked = input.value === value;
}

/** Sets a control's value and the text beside it. */
export function setValue(id, value, text) {
  if (find(id).value !== String(value)) find(id).value = value;
  setText(`${id}-text`, text);
}

/** Sets the text of the element of an identifier. */
export function setText(id, text) {
  setTextOf(find(id), text);
}

/** Sets the text of an element if it is another one: screen readers do not repeat it, and nothing is laid out again. */
function setTextOf(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function fillSelect(select, names) {
  select.replaceChildren(...names.map((name) => new Option(name)));
}

/** Fills the body of `table` with `rows` [name, text, tooltip], and changes only what is new. */
export function fillTable(table, rows) {
  const body = table.tBodies[0] ?? table.createTBody();
  while (body.rows.length > rows.length) body.deleteRow(-1);
  rows.forEach(([name, text, tooltip], i) => {
    const row = body.rows[i] ?? addRow(body);
    setTextOf(row.cells[0], name);
    setTextOf(row.cells[1], text);
    row.title = tooltip ?? "";
  });
}

function addRow(body) {
  const row = body.insertRow();
  const head = document.createElement("th");
  head.scope = "row";
  row.append(head);
  row.insertCell();
  return row;
}
