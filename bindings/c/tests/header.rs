//! The committed header is the one that the source gives. `LTBW_WRITE_HEADER=1` writes it.

use std::path::Path;

/// Structs that may grow, which know their size.
const NEW: [&str; 4] = ["ltbw_run", "ltbw_points", "ltbw_surface", "ltbw_wishes"];

/// A function of the header: an empty struct that knows its size.
fn new(name: &str) -> String {
    format!(
        "/* One of zeros, which asks for nothing, and its size. */\n\
         static inline {name} {name}_new(void) {{\n  {name} made;\n  \
         memset(&made, 0, sizeof made);\n  made.struct_size = (uint32_t)sizeof made;\n  \
         return made;\n}}"
    )
}

#[test]
fn the_header_is_that_of_the_source() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut config =
        cbindgen::Config::from_file(folder.join("cbindgen.toml")).expect("configuration");
    let [major, minor, patch] = [
        env!("CARGO_PKG_VERSION_MAJOR"),
        env!("CARGO_PKG_VERSION_MINOR"),
        env!("CARGO_PKG_VERSION_PATCH"),
    ];
    config.after_includes = Some(format!(
        "\n/* The version of this header. */\n#define LTBW_VERSION_MAJOR {major}\n\
         #define LTBW_VERSION_MINOR {minor}\n#define LTBW_VERSION_PATCH {patch}"
    ));
    config.trailer = Some(NEW.iter().map(|name| new(name)).collect::<Vec<_>>().join("\n\n"));
    let mut text = Vec::new();
    cbindgen::Builder::new()
        .with_crate(folder)
        .with_config(config)
        .generate()
        .expect("a header")
        .write(&mut text);
    let text = String::from_utf8(text).expect("text");
    // Rust's headline means nothing to readers of C.
    let text = text.replace("\n # Safety\n", "\n What the caller promises:\n\n");
    let place = folder.join("include/ltbw.h");
    if std::env::var_os("LTBW_WRITE_HEADER").is_some() {
        std::fs::write(&place, &text).expect("written");
    }
    let committed = std::fs::read_to_string(&place).expect("the committed header");
    assert!(committed == text, "the header is old: LTBW_WRITE_HEADER=1 cargo test --test header");
}
