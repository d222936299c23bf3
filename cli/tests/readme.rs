//! README.md shows what the program really prints: the demo's output, apart from its times and from
//! how many tests the filter decided, and the commands in the list of examples.

use crate::common::ltbw;

const README: &str = include_str!("../../README.md");

/// Numbers that may change become `0`: times, and how many tests the checker's filter decided,
/// which depends on the order of a tetrahedron's vertices.
fn without_chance(line: &str) -> String {
    if !line.starts_with("seconds ") && !line.starts_with("checked ") {
        return line.to_string();
    }
    let numbers = line.split(' ').map(|word| {
        let number = word.trim_start_matches('(').trim_end_matches([':', ',']);
        if number.parse::<f64>().is_ok() { word.replace(number, "0") } else { word.to_string() }
    });
    numbers.collect::<Vec<_>>().join(" ")
}

#[test]
fn the_demo_prints_what_the_readme_shows() {
    let start = README.find("$ cargo run --release -p ltbw-cli -- demo\n").unwrap();
    let block = README[start..].split("```").next().unwrap();
    let shown: Vec<String> = block.lines().skip(1).map(without_chance).collect();

    let dir = tempfile::tempdir().unwrap();
    let run = ltbw(dir.path(), &["demo"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // The README leaves out what comes after the empty line: what to do next.
    let mut printed: Vec<String> =
        run.stderr.lines().take_while(|line| !line.is_empty()).map(without_chance).collect();
    printed.extend(run.stdout.lines().map(str::to_string));
    assert_eq!(shown, printed);
}

#[test]
fn its_example_commands_are_understood() {
    let examples: Vec<&str> = README.lines().filter(|line| line.starts_with("ltbw ")).collect();
    assert!(examples.len() >= 4, "{examples:?}");
    let dir = tempfile::tempdir().unwrap();
    let points = ltbw(dir.path(), &["generate", "uniform", "50", "-o", "points.npy"]);
    assert_eq!(points.code, 0, "{}", points.stderr);
    let path = dir.path().join("points.npy");
    let mut few = ltbw::io::read_points(&path).unwrap();
    few.points.truncate(5);
    ltbw::io::write_points(dir.path().join("gone.npy"), &few).unwrap();
    for example in examples {
        // Two blanks separate a command from what is said of it.
        let command = example.split("  ").next().unwrap();
        // A small set stands for the million.
        let args: Vec<&str> = command.split(' ').skip(1).collect();
        let args: Vec<&str> =
            args.iter().map(|a| if *a == "1000000" { "50" } else { *a }).collect();
        let run = ltbw(dir.path(), &args);
        assert_eq!(run.code, 0, "{command}: {}", run.stderr);
    }
}

/// The STL of the walk `docs/first-mesh.md`: a cylinder of 48 sides, ends as fans.
pub(crate) fn cylinder() -> String {
    let sides = 48;
    let corner = |side: usize, z: f64| {
        let angle = (side % sides) as f64 / sides as f64 * std::f64::consts::TAU;
        [angle.cos() / 2.0, angle.sin() / 2.0, z]
    };
    let mut text = "solid\n".to_string();
    for side in 0..sides {
        let [a, b] = [corner(side, 0.0), corner(side + 1, 0.0)];
        let [c, d] = [corner(side + 1, 1.0), corner(side, 1.0)];
        let (low, high) = ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        for triangle in [[a, b, c], [a, c, d], [low, b, a], [high, d, c]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle {
                text += &format!("vertex {x:?} {y:?} {z:?}\n");
            }
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid\n"
}

/// The commands of the walk run, one after the other; the cylinder has the parts that it says.
#[test]
fn the_walk_s_commands_do_what_it_says() {
    let walk = include_str!("../../docs/first-mesh.md");
    let commands: Vec<&str> = walk.lines().filter(|line| line.starts_with("ltbw ")).collect();
    assert!(commands.len() >= 4, "{commands:?}");
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("cylinder.stl"), cylinder()).unwrap();
    for command in commands {
        let args: Vec<&str> = command.split(' ').skip(1).collect();
        let run = ltbw(dir.path(), &args);
        assert_eq!(run.code, 0, "{command}: {}", run.stderr);
    }
    let mesh = std::fs::read(dir.path().join("cylinder.msh")).unwrap();
    let mesh = String::from_utf8_lossy(&mesh);
    for name in ["part 1", "part 2", "part 3"] {
        assert!(mesh.contains(&format!("\"{name}\"")), "no {name}");
    }
    assert!(!mesh.contains("\"part 4\""));
}
