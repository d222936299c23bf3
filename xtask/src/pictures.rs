//! `pictures`: the README's pictures, taken of our own pages with Chromium.

use crate::require;
use crate::shell::{self, cargo, command, root, target, works};
use std::path::Path;

/// The name of a picture, the command that writes its page, and the view of it.
const PICTURES: [(&str, &[&str], &str); 2] = [
    (
        "gear",
        &["mesh", "gear.poly", "--size", "0.06", "--page", "demo.html"],
        "cut=x:0.5&yaw=-0.6&pitch=0.5",
    ),
    (
        "workers",
        &["delaunay", "points.npy", "--threads", "8", "--page", "demo.html"],
        "cut=view:0.55&colour=worker&yaw=-0.7&pitch=0.5",
    ),
];

/// Takes the pictures anew.
pub(crate) fn run() -> Result<(), String> {
    let browser = std::env::var("LTBW_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    if !works(command(&browser).arg("--version")) {
        return require::skip("pictures", "chromium", &format!("{browser} does not start"));
    }
    shell::run(cargo().args(["build", "--quiet", "--release", "-p", "ltbw-cli"]))?;
    let program = target().join("release/ltbw").to_string_lossy().into_owned();
    let folder = target().join("pictures");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let points = ["generate", "uniform", "15000", "-o", "points.npy"];
    for input in [&points[..], &["generate", "gear", "-o", "gear.poly"]] {
        shell::run(command(&program).current_dir(&folder).args(input))?;
    }
    for (name, args, view) in PICTURES {
        shell::run(command(&program).current_dir(&folder).args(args))?;
        let picture = root().join(format!("docs/{name}.png"));
        photograph(&browser, &folder, view, &picture)?;
        println!("wrote {}", picture.display());
    }
    Ok(())
}

/// A picture of the page in `folder`.
fn photograph(browser: &str, folder: &Path, view: &str, picture: &Path) -> Result<(), String> {
    let profile = folder.join("profile");
    let taken = command(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"])
        .args(["--disable-background-networking", "--hide-scrollbars", "--window-size=560,440"])
        .arg("--virtual-time-budget=20000")
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("--screenshot={}", picture.display()))
        .arg(format!("file://{}#bare=1&{view}", folder.join("demo.html").display()))
        .output()
        .map_err(|e| format!("{browser}: {e}"))?;
    // A browser that fails to take a picture may succeed all the same.
    if taken.status.success() && picture.exists() {
        return Ok(());
    }
    Err(format!("{browser}: {}\n{}", taken.status, String::from_utf8_lossy(&taken.stderr)))
}
