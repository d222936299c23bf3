//! Pages in a browser: Chromium without a window. `LTBW_CHROMIUM` names another program than
//! `chromium`.

use crate::common::ltbw;
use crate::require;
use ltbw::io;
use ltbw::quality::TetQuality;
use std::path::Path;
use std::process::Command;

/// A box of 2 x 1 x 1, cut in two by a facet with a marker of its own, and a region on either side.
const TWO_ROOMS: &str = "\
12 3 0 0
0 0 0 0
1 1 0 0
2 2 0 0
3 0 1 0
4 1 1 0
5 2 1 0
6 0 0 1
7 1 0 1
8 2 0 1
9 0 1 1
10 1 1 1
11 2 1 1
11 1
1 0 1
4 0 1 4 3
1 0 1
4 1 2 5 4
1 0 2
4 6 7 10 9
1 0 2
4 7 8 11 10
1 0 3
4 0 1 7 6
1 0 3
4 1 2 8 7
1 0 3
4 3 4 10 9
1 0 3
4 4 5 11 10
1 0 4
4 0 3 9 6
1 0 5
4 2 5 11 8
1 0 6
4 1 4 10 7
0
2
0 0.5 0.5 0.5 10 -1
1 1.5 0.5 0.5 20 -1
";

/// A page as a browser shows it.
struct Visit {
    /// The document after its scripts have run.
    dom: String,
    /// A picture of the window.
    picture: Vec<u8>,
}

impl Visit {
    /// The text of the element that begins with `tag`.
    fn text(&self, tag: &str) -> &str {
        let (_, rest) = self.dom.split_once(tag).unwrap_or_else(|| panic!("{tag}: {}", self.dom));
        rest.split_once('<').unwrap().0
    }

    /// The number of tetrahedra that the page shows, and of all.
    fn shown(&self) -> (usize, usize) {
        let text = self.text("<output id=\"shown\">").replace(',', "");
        let number = |k| text.split(' ').nth(k).and_then(|n| n.parse().ok());
        (number(0).expect(&text), number(2).expect(&text))
    }
}

/// Chromium, if there is one.
fn browser() -> Option<Browser> {
    let program = std::env::var("LTBW_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    match Command::new(&program).arg("--version").output() {
        Ok(output) if output.status.success() => Some(Browser { program }),
        Ok(output) => skip(&format!("{program}: {}", output.status)),
        Err(error) => skip(&format!("{program}: {error}")),
    }
}

fn skip(reason: &str) -> Option<Browser> {
    require::skip("pages in a browser", "chromium", reason).unwrap();
    None
}

struct Browser {
    program: String,
}

impl Browser {
    /// Opens a page at an address within it. Whatever the page writes to its console is an error.
    fn visit(&self, page: &Path, address: &str) -> Visit {
        self.visit_in("900,700", page, address)
    }

    /// The visit in a window of that size.
    fn visit_in(&self, window: &str, page: &Path, address: &str) -> Visit {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("picture.png");
        let run = |what: &str| {
            let output = Command::new(&self.program)
                .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic"])
                .args(["--enable-unsafe-swiftshader", "--no-first-run", "--disable-sync"])
                .args(["--disable-background-networking", "--disable-component-update"])
                .args(["--hide-scrollbars", "--enable-logging=stderr"])
                .arg(format!("--window-size={window}"))
                .arg("--virtual-time-budget=20000")
                .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
                .arg(what)
                .arg(format!("file://{}#{address}", page.display()))
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{said}");
            // The driver's remark on reading pixels is about taking the picture.
            let console = |l: &&str| l.contains(":CONSOLE") && !l.contains("GL Driver Message");
            assert_eq!(said.lines().filter(console).collect::<Vec<_>>(), [""; 0], "{address}");
            String::from_utf8(output.stdout).unwrap()
        };
        let dom = run("--dump-dom");
        run(&format!("--screenshot={}", picture.display()));
        Visit { dom, picture: std::fs::read(picture).unwrap() }
    }
}

#[test]
fn a_page_is_one_small_file_that_asks_nobody() {
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["demo"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let page = std::fs::read_to_string(dir.path().join("demo.html")).unwrap();
    assert!(page.len() < 2_000_000, "{}", page.len());
    for word in ["src=", "href=", "url(", "@import", "import(", "fetch(", "XMLHttp"] {
        assert!(!page.contains(word), "{word}");
    }
    let addresses = page.matches("://").count();
    assert_eq!(addresses, page.matches("http://www.w3.org/2000/svg").count());
}

#[test]
fn a_mesh_is_turned_cut_and_asked() {
    let Some(browser) = browser() else { return };
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("rooms.poly"), TWO_ROOMS).unwrap();
    let args = ["mesh", "rooms.poly", "--max-volume", "0.002", "-o", "m.vtu", "--page", "m.html"];
    let run = ltbw(dir.path(), &args);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let page = dir.path().join("m.html");
    let mesh = io::read_mesh(dir.path().join("m.vtu")).unwrap();

    let whole = browser.visit(&page, "cut=none&colour=region&bare=1");
    assert!(whole.dom.contains("data-ready=\"yes\""), "{}", whole.text("<output id=\"shown\">"));
    assert_eq!(whole.shown(), (mesh.tets.len(), mesh.tets.len()));
    for text in ["region 1", "region 2"] {
        assert!(whole.dom.contains(text), "{text}");
    }
    // A cut for each of two places: two pictures; the same one again is the same.
    let [a, b, c] = ["x:0.3", "x:0.7", "x:0.3"]
        .map(|cut| browser.visit(&page, &format!("cut={cut}&colour=angle&bare=1")));
    assert!(a.shown().0 < b.shown().0 && b.shown().0 < mesh.tets.len());
    assert!(a.picture != b.picture && a.picture == c.picture);
    assert!(a.picture.len() > 5_000, "a picture of something: {} bytes", a.picture.len());
    // Colours differ, too.
    let marked = browser.visit(&page, "cut=x:0.3&colour=marker&bare=1");
    assert!(marked.picture != a.picture && marked.dom.contains("marker 6"));

    // Measures of the page are those of the library.
    let least = |tet: &[u32; 4]| {
        let quality = TetQuality::of(tet.map(|v| &mesh.points[v as usize]));
        quality.dihedral.into_iter().fold(f64::INFINITY, f64::min)
    };
    let bad = mesh.tets.iter().filter(|tet| least(tet) < 30.0).count();
    assert!(bad > 0);
    let asked = browser.visit(&page, "cut=none&worse=30&tet=5");
    assert_eq!(asked.shown().0, bad);
    let figures = asked.dom.split_once("<div id=\"picked\">").unwrap().1;
    let figures = figures.split_once("</div>").unwrap().0;
    assert!(figures.contains("<td>tetrahedron</td><td>5</td>"), "{figures}");
    for v in mesh.tets[5] {
        assert!(figures.contains(&format!("<td>vertex {v}</td>")), "{figures}");
    }
    let volume = TetQuality::of(mesh.tets[5].map(|v| &mesh.points[v as usize])).volume;
    let (_, rest) = figures.split_once("<td>volume</td><td>").unwrap();
    let told: f64 = rest.split_once('<').unwrap().0.parse().unwrap();
    assert!((told - volume).abs() < 1e-4 * volume, "{told} {volume}");
}

/// The first view of a page fills its frame, on a phone and on a desk.
#[test]
fn the_mesh_fills_its_frame() {
    let Some(browser) = browser() else { return };
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["demo"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    for window in ["500,900", "1600,900"] {
        let visit = browser.visit_in(window, &dir.path().join("demo.html"), "measure=1");
        let figure = |name: &str| -> f64 {
            let (_, rest) = visit.dom.split_once(&format!("data-{name}=\"")).expect(name);
            rest.split_once('"').unwrap().0.parse().unwrap()
        };
        assert!(figure("filled") >= 0.5, "{window}: {}", figure("filled"));
        assert!(figure("beyond") <= 0.0, "{window}: {} pixels beyond the window", figure("beyond"));
    }
}

#[test]
fn clicks_and_controls_work() {
    let Some(browser) = browser() else { return };
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("rooms.poly"), TWO_ROOMS).unwrap();
    let args = ["mesh", "rooms.poly", "--max-volume", "0.01", "--page", "m.html"];
    let run = ltbw(dir.path(), &args);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let page = std::fs::read_to_string(dir.path().join("m.html")).unwrap();
    // A hand that drags, clicks the middle, and moves the slider.
    let hand = "<script>const hand = setInterval(() => {
        if (document.body.dataset.drawn === undefined) return;
        clearInterval(hand);
        const canvas = document.getElementById('canvas'), box = canvas.getBoundingClientRect();
        const x = box.left + box.width / 2, y = box.top + box.height / 2;
        const event = (kind, dx) => canvas.dispatchEvent(new PointerEvent(kind,
          { pointerId: 1, clientX: x + dx, clientY: y, bubbles: true }));
        event('pointerdown', 0); event('pointermove', 40); event('pointerup', 40);
        document.body.dataset.afterDrag = document.getElementById('picked').textContent;
        event('pointerdown', 0); event('pointerup', 0);
        const place = document.getElementById('place');
        place.value = 0.25;
        place.dispatchEvent(new Event('input'));
        document.body.dataset.address = location.hash;
        // A browser without a window has nobody to hand the file to.
        HTMLAnchorElement.prototype.click = () => {};
        document.getElementById('export').click();
      }, 20);</script></html>";
    let path = dir.path().join("hand.html");
    std::fs::write(&path, page.replace("</html>", hand)).unwrap();
    let visit = browser.visit(&path, "cut=z:0.9");
    assert!(visit.dom.contains("data-after-drag=\"\""), "a drag is no click");
    assert!(visit.dom.contains("<td>tetrahedron</td>"), "a click in the middle hits the mesh");
    let address = visit.dom.split_once("data-address=\"").unwrap().1.split_once('"').unwrap().0;
    assert!(visit.dom.contains("data-saved=\""), "a part is saved");
    assert!(address.contains("cut=z%3A0.25") && address.contains("tet="), "{address}");
}

#[test]
fn workers_have_colours_and_a_timeline() {
    let Some(browser) = browser() else { return };
    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["generate", "uniform", "20000", "-o", "p.npy"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = ltbw(dir.path(), &["delaunay", "p.npy", "--threads", "2", "--page", "p.html"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let visit = browser.visit(&dir.path().join("p.html"), "colour=worker");
    assert!(visit.dom.contains("worker 0") && visit.dom.contains("worker 1"));
    assert!(visit.dom.contains("data-times=\"2\""));

    let args = ["simulate", "--processors", "4", "--points", "5000", "--page", "s.html"];
    let run = ltbw(dir.path(), &args);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let visit = browser.visit(&dir.path().join("s.html"), "");
    assert!(visit.dom.contains("data-times=\"4\""));
    for text in ["LT over latency", "Speed-up over processors", "1 ms: "] {
        assert!(visit.dom.contains(text), "{text}");
    }
}
