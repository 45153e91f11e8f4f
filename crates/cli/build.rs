//! Removes the symbols of the released programs: they were a quarter of their size.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let is = |name: &str, value: &str| std::env::var(name).is_ok_and(|set| set == value);
    if is("PROFILE", "release") && (is("CARGO_CFG_TARGET_OS", "linux") || is("CARGO_CFG_TARGET_ENV", "gnu")) {
        println!("cargo::rustc-link-arg-bins=-Wl,--strip-all");
    }
}
