//! The shared library's name for the loader: programs ask for the major version.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let on = |name: &str| std::env::var(name).unwrap_or_default();
    if on("CARGO_CFG_TARGET_OS") == "linux" {
        let major = on("CARGO_PKG_VERSION_MAJOR");
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libltbw.so.{major}");
    }
}
