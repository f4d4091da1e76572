// The rules for JavaScript: of the page, of the tests of its modules, and of the programs that talk to its port.
import js from "@eslint/js";
import globals from "globals";

const PAGE = "src/pyros1/web/page";

export default [
  { ignores: [`${PAGE}/vendor/**`, "**/node_modules/**"] },
  js.configs.recommended,
  {
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      "array-callback-return": "error",
      "consistent-return": "error",
      "default-case-last": "error",
      eqeqeq: "error",
      "no-constructor-return": "error",
      "no-eval": "error",
      "no-implied-eval": "error",
      "no-new-func": "error",
      "no-self-compare": "error",
      "no-throw-literal": "error",
      "no-unmodified-loop-condition": "error",
      "no-unreachable-loop": "error",
      "no-unused-expressions": "error",
      "no-unused-vars": ["error", { argsIgnorePattern: "^_" }],
      "no-use-before-define": ["error", { functions: false, classes: false, variables: false }],
      "no-useless-return": "error",
      "no-var": "error",
      "object-shorthand": "error",
      "prefer-const": "error",
      "prefer-promise-reject-errors": "error",
      radix: "error",
    },
  },
  { files: [`${PAGE}/**/*.js`], languageOptions: { globals: globals.browser } },
  { files: [`${PAGE}/**/worker.js`], languageOptions: { globals: globals.worker } },
  { files: ["tests/**/*.mjs", "interop/**/*.{js,mjs}"], languageOptions: { globals: globals.node } },
];
