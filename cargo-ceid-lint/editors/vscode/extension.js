// Starts `cargo-ceid-lint lsp`, which is found on PATH, for Rust files and for what configures them.
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const server = { command: "cargo-ceid-lint", args: ["lsp"] };
  const documentSelector = [
    { scheme: "file", language: "rust" },
    { scheme: "file", pattern: "**/{Cargo,ceid-lint}.toml" },
  ];
  client = new LanguageClient("ceid-lint", server, { documentSelector });
  return client.start();
};

exports.deactivate = () => client?.stop();
