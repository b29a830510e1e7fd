//! Configuration that is changed in the editor, and not saved.

use serde_json::{Value, json};

use super::client::{Client, plain};
use super::{codes, guilty, places};
use crate::support::workspace::{GUILTY, write};

#[test]
fn unsaved_configuration_is_checked_as_it_is_typed() {
    let (folder, file) = guilty("lsp_unsaved_configuration");
    let config = folder.join("ceid-lint.toml");
    let mut client = Client::in_folder(&folder, &plain());
    assert_eq!(client.published(&file)["diagnostics"][0]["severity"], 1);
    // The file is not even there.
    client.open(&config, "[lints]\nrepeated_update = \"warn\"\n");
    assert_eq!(client.published(&file)["diagnostics"][0]["severity"], 2);
    client.replace(&config, 2, "[lints]\nrepeated_updat = \"warn\"\n");
    let told = client.published_of(&config, 2);
    assert_eq!(places(&told), [[1, 0, 14]]);
    client.replace(&config, 3, "");
    assert_eq!(client.published_of(&config, 3), json!([]));
    assert_eq!(client.pull(&file)[0]["severity"], 1);

    // What is on the disk holds again when the editor gives the file up.
    write(&folder, "ceid-lint.toml", b"[lints]\nrepeated_update = \"allow\"\n");
    client.close(&config);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
}

#[test]
fn unsaved_metadata_of_a_manifest_is_checked_as_it_is_typed() {
    let (folder, file) = guilty("lsp_unsaved_metadata");
    let manifest = folder.join("Cargo.toml");
    let saved = std::fs::read_to_string(&manifest).expect("it is there");
    let with = |level: &str| format!("{saved}\n[package.metadata.ceid-lint.lints]\nrepeated_update = \"{level}\"\n");
    let mut client = Client::in_folder(&folder, &plain());
    assert_eq!(client.pull(&file)[0]["severity"], 1);
    client.open(&manifest, &saved);
    client.replace(&manifest, 2, &with("warn"));
    assert_eq!(client.pull(&file)[0]["severity"], 2);
    client.replace(&manifest, 3, &with("wran"));
    assert_eq!(client.published_of(&manifest, 3).as_array().map(Vec::len), Some(1));
    // Half a manifest changes nothing: what it was before is not taken away while it is written.
    client.replace(&manifest, 4, "[package");
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
    client.replace(&manifest, 5, &saved);
    assert_eq!(client.pull(&file)[0]["severity"], 1);
}

#[test]
fn unsaved_text_and_unsaved_configuration_go_together() {
    let (folder, file) = guilty("lsp_unsaved_both");
    let text = GUILTY.replacen("impl SampledFilter for Kalman { fn update", "impl Kalman { pub fn update", 1);
    let mut client = Client::in_folder(&folder, &plain());
    client.open(&file, &text);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
    let config = folder.join("ceid-lint.toml");
    client.open(&config, "[[filter]]\ntype = \"crate::Kalman\"\nlaw = \"update\"\n");
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
}
