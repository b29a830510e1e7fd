//! A set has any number of filters: no macro of the library recurses over them.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn three_hundred_filters_in_one_set() {
    let (mut fields, mut values) = (String::new(), String::new());
    for filter in 0..300 {
        let divider = if filter % 3 == 0 { ", every 10" } else { "" };
        write!(fields, "f{filter}: Count{divider}; ").expect("a string takes everything");
        values += "Count(0), ";
    }
    let program = format!(
        "use ceid_core::prelude::*;
        struct Count(u32);
        impl<R: Rate> SampledFilter<R> for Count {{ fn update(&mut self, _: Tick<'_, R>) {{ self.0 += 1 }} }}
        filters! {{ struct Filters @ 1000 Hz {{ {fields} }} }}
        fn main() {{
            let mut control = Cyclic::new(Filters::register({values}), Free::<Hz<1000>>::new().take(11));
            each_cycle!(_f in control => {{}});
            let f = control.filters();
            assert_eq!((f.f0.0, f.f1.0, f.f297.0, f.f299.0), (2, 11, 2, 11));
        }}"
    );
    let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join("many");
    let manifest = format!(
        "[workspace]\n[package]\nname = \"many\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\
         [dependencies]\nceid-core = {{ path = {:?} }}\n",
        env!("CARGO_MANIFEST_DIR")
    );
    fs::create_dir_all(root.join("src")).expect("the target directory can be written");
    fs::write(root.join("Cargo.toml"), manifest).expect("the target directory can be written");
    fs::write(root.join("src/main.rs"), program).expect("the target directory can be written");
    let output = Command::new(env!("CARGO"))
        .args(["run", "--offline", "--quiet"])
        .env("CARGO_TARGET_DIR", root.join("target"))
        .current_dir(&root)
        .output()
        .expect("cargo can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
