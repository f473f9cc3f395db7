// Lint of the pages' scripts. Names that no module imports, and cycles of imports, are faults.
import js from "@eslint/js";
import globals from "globals";

export default [
  {
    files: ["warpvec/**/*.js", "tests/viewer/*.js"],
    languageOptions: { ecmaVersion: 2024, sourceType: "module", globals: globals.browser },
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      ...js.configs.recommended.rules,
      eqeqeq: "error",
      "no-unused-vars": ["error", { ignoreRestSiblings: true }],
      "no-var": "error",
      "prefer-const": "error",
      "no-shadow": "error",
      "no-duplicate-imports": "error",
      "no-restricted-globals": ["error", "find", "name", "event", "status"],
      "no-eval": "error",
      "no-implied-eval": "error",
      "max-len": ["error", { code: 140 }],
    },
  },
];
