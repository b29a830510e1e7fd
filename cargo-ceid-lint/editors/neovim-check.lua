-- Drives the language server with Neovim's own client, without a window, and prints what the editor would show.
--
-- Started by neovim-check.sh.
-- CEID_LINT is the program, and CEID_FILE the file to open; CEID_ROOT is the folder, if there is one.

local function say(text)
  io.stdout:write(text .. "\n")
end

local clients = vim.lsp.get_clients or vim.lsp.get_active_clients

local function leave(code)
  for _, client in ipairs(clients()) do
    vim.lsp.stop_client(client.id)
  end
  vim.wait(5000, function()
    return #clients() == 0
  end, 20)
  vim.cmd((code == 0) and "qall!" or "cquit!")
end

local function shown(buffer)
  return vim.diagnostic.get(buffer)
end

-- Waits until the number of findings is the expected one.
local function await(buffer, holds, what)
  local came = vim.wait(60000, function()
    return holds(shown(buffer))
  end, 50)
  if not came then
    say("not seen: " .. what)
    leave(1)
  end
end

local function print_findings(title, buffer)
  say(title .. ": " .. #shown(buffer))
  for _, finding in ipairs(shown(buffer)) do
    local first_line = finding.message:match("[^\n]*")
    say(string.format("  %d:%d %s %s", finding.lnum + 1, finding.col + 1, finding.code or "-", first_line))
    local related = vim.tbl_get(finding, "user_data", "lsp", "relatedInformation") or {}
    for _, step in ipairs(related) do
      say(string.format("    %d: %s", step.location.range.start.line + 1, step.message))
    end
  end
end

-- From 0.11 as the documentation has it, before that by hand. Answers the number of the client.
local function start()
  local cmd = { os.getenv("CEID_LINT"), "lsp" }
  local edit = "edit " .. vim.fn.fnameescape(os.getenv("CEID_FILE"))
  if vim.lsp.config then
    vim.lsp.config("ceid_lint", {
      cmd = cmd,
      filetypes = { "rust", "toml" },
      root_markers = { "ceid-lint.toml", "Cargo.lock", "Cargo.toml" },
      settings = { ["ceid-lint"] = { inlayHints = true } },
    })
    vim.lsp.enable("ceid_lint")
    vim.cmd("filetype on")
    vim.cmd(edit)
    vim.wait(60000, function()
      return #clients() > 0
    end, 20)
    return clients()[1] and clients()[1].id
  end
  vim.cmd(edit)
  local root = os.getenv("CEID_ROOT")
  local id = vim.lsp.start_client({
    name = "ceid-lint",
    cmd = cmd,
    root_dir = root,
    workspace_folders = root and { { uri = vim.uri_from_fname(root), name = "root" } } or nil,
  })
  if id then
    vim.lsp.buf_attach_client(0, id)
  end
  return id
end

local id = start()
if not id then
  say("the server does not start")
  vim.cmd("cquit!")
end
local client = vim.lsp.get_client_by_id(id)
local buffer = vim.api.nvim_get_current_buf()

await(buffer, function(found)
  return #found > 0
end, "a finding")
print_findings("findings", buffer)
local first = shown(buffer)[1]
local count = #shown(buffer)

local params = {
  textDocument = { uri = vim.uri_from_bufnr(buffer) },
  position = { line = first.lnum, character = first.col },
}
local hover = vim.lsp.buf_request_sync(buffer, "textDocument/hover", params, 60000)
say("hover: " .. hover[id].result.contents.value:match("[^\n]*"))

-- The suppression, done as the editor does it.
local asked = vim.lsp.util.make_range_params(0, client.offset_encoding)
asked.range = {
  start = { line = first.lnum, character = first.col },
  ["end"] = { line = first.end_lnum, character = first.end_col },
}
asked.context = { diagnostics = { first.user_data.lsp } }
local actions = vim.lsp.buf_request_sync(buffer, "textDocument/codeAction", asked, 60000)
local suppression
for _, action in ipairs(actions[id].result) do
  say("action: " .. action.title)
  if action.title:match("^suppress") then
    suppression = action
  end
end
vim.lsp.util.apply_workspace_edit(suppression.edit, client.offset_encoding)
await(buffer, function(found)
  return #found == count - 1
end, "one finding less after the suppression")
print_findings("after the suppression", buffer)

-- And back: nothing stale in either direction.
vim.cmd("silent undo")
await(buffer, function(found)
  return #found == count
end, "the finding again after undo")
print_findings("after undo", buffer)

if vim.lsp.inlay_hint then
  vim.lsp.inlay_hint.enable(true)
  vim.wait(60000, function()
    return #vim.lsp.inlay_hint.get() > 0
  end, 50)
  for _, hint in ipairs(vim.lsp.inlay_hint.get()) do
    say(string.format("hint behind line %d: %s", hint.inlay_hint.position.line + 1, hint.inlay_hint.label))
  end
end
leave(0)
