//! Tells the program for which target it is built: the first guess at the host of those who run it.

fn main() {
    let target = std::env::var("TARGET").expect("cargo tells it to build scripts");
    println!("cargo::rustc-env=BUILT_FOR={target}");
    println!("cargo::rerun-if-changed=build.rs");
}
