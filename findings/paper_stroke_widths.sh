#!/bin/bash
# paper.js scales the shapes of an SVG by its view box, and by transforms, but not the widths of their strokes.
#
# A line of 20 units, 2 wide, in a view box of 24 units that is shown 240 pixels wide: it should be 200 pixels long and 20
# wide. With paper 0.12.18 (and drawn, 0.12.20) it is 200 long and 2 wide; the same in a group that is scaled by 10. SVG 1.1, section 11.4:
# the width is in the user units of the stroked element.
# Seen: viewBox 200 x 2; transform 200 x 2.
# Needs Node.js 20 with npm.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund paper@0.12.18 paper-jsdom@0.12.18 > npm.log 2>&1
cat > lines.js <<'JS'
const paper = require("paper-jsdom");
const line = '<path fill="none" stroke="#000" stroke-width="2" d="M2 12h20"/>';
const head = '<svg xmlns="http://www.w3.org/2000/svg" width="240" height="240" viewBox="0 0';
const files = { viewBox: `${head} 24 24">${line}</svg>`, transform: `${head} 240 240"><g transform="scale(10)">${line}</g></svg>` };
let isAsSeen = true;
for (const [name, text] of Object.entries(files)) {
  paper.setup(new paper.Size(240, 240));
  paper.project.importSVG(text);
  const [found] = paper.project.getItems({ class: paper.Path, match: (item) => item.hasStroke() });
  console.log(name, Math.round(found.length), "x", found.strokeWidth);
  isAsSeen &&= Math.round(found.length) === 200 && found.strokeWidth === 2;
}
process.exit(isAsSeen ? 0 : 1);
JS
node lines.js
