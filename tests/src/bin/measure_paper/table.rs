//! Tables and pictures as Markdown, and as one page.

use std::fmt::Write as _;

/// A part of the result.
pub(crate) enum Block {
    Table(Table),
    Picture(Picture),
}

/// A table with a title, and words below it.
pub(crate) struct Table {
    pub(crate) title: String,
    pub(crate) head: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
    pub(crate) below: String,
}

/// A picture, as SVG.
pub(crate) struct Picture {
    pub(crate) title: String,
    pub(crate) svg: String,
    pub(crate) below: String,
}

/// Cells of text.
pub(crate) fn cells<const N: usize>(all: [&str; N]) -> Vec<String> {
    all.map(str::to_owned).to_vec()
}

/// Seconds with as many digits as make sense.
pub(crate) fn seconds(value: f64) -> String {
    match value {
        v if v >= 1000.0 => format!("{v:.0}"),
        v if v >= 1.0 => format!("{v:.1}"),
        v => format!("{v:.3}"),
    }
}

/// Nanoseconds as seconds.
pub(crate) fn of_nanos(value: f64) -> String {
    seconds(value * 1e-9)
}

/// A share in percent.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// All blocks as Markdown; pictures are on the page alone.
pub(crate) fn markdown(blocks: &[Block]) -> String {
    let mut text = String::new();
    for block in blocks {
        match block {
            Block::Table(table) => {
                let _ = writeln!(text, "### {}\n", table.title);
                let _ = writeln!(text, "| {} |", table.head.join(" | "));
                let bars =
                    table.head.iter().enumerate().map(|(k, _)| if k == 0 { "---" } else { "--:" });
                let _ = writeln!(text, "|{}|", bars.collect::<Vec<_>>().join("|"));
                for row in &table.rows {
                    let _ = writeln!(text, "| {} |", row.join(" | "));
                }
                let _ = writeln!(text, "\n{}\n", table.below);
            }
            Block::Picture(_) => {}
        }
    }
    text
}

/// All blocks as a page that needs nothing else.
pub(crate) fn page(blocks: &[Block]) -> String {
    let mut text = String::from(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\">\
         <title>The paper's tables and figures</title>\n\
         <style>body{font:15px sans-serif;max-width:70em;margin:2em auto;padding:0 1em}\
         table{border-collapse:collapse}\
         td,th{border-bottom:1px solid #ddd;padding:.2em .7em;text-align:right}\
         td:first-child,th:first-child{text-align:left}p{color:#444}svg{max-width:100%}</style>\n\
         <h1>The paper's tables and figures</h1>\n",
    );
    for block in blocks {
        match block {
            Block::Table(table) => {
                let _ = writeln!(text, "<h2>{}</h2>\n<table>", escaped(&table.title));
                let row = |tag: &str, cells: &[String]| {
                    let cells = cells.iter().map(|c| format!("<{tag}>{}</{tag}>", escaped(c)));
                    format!("<tr>{}</tr>", cells.collect::<String>())
                };
                let _ = writeln!(text, "{}", row("th", &table.head));
                for cells in &table.rows {
                    let _ = writeln!(text, "{}", row("td", cells));
                }
                let _ = writeln!(text, "</table>\n<p>{}</p>", escaped(&table.below));
            }
            Block::Picture(Picture { title, svg, below }) => {
                let _ =
                    writeln!(text, "<h2>{}</h2>\n{svg}\n<p>{}</p>", escaped(title), escaped(below));
            }
        }
    }
    text
}

/// Text within HTML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_the_same_on_both() {
        let table = Table {
            title: "T < 1".into(),
            head: cells(["what", "run"]),
            rows: vec![cells(["a & b", "1"])],
            below: "Below.".into(),
        };
        let blocks = [Block::Table(table)];
        assert_eq!(
            markdown(&blocks),
            "### T < 1\n\n| what | run |\n|---|--:|\n| a & b | 1 |\n\nBelow.\n\n"
        );
        let page = page(&blocks);
        assert!(
            page.contains("<h2>T &lt; 1</h2>") && page.contains("<td>a &amp; b</td><td>1</td>")
        );
    }

    #[test]
    fn numbers_have_as_many_digits_as_make_sense() {
        let all = [1165.2, 24.28, 0.0123].map(seconds);
        assert_eq!(all, ["1165", "24.3", "0.012"]);
        assert_eq!((of_nanos(2.5e9), percent(0.142)), ("2.5".into(), "14.2 %".into()));
    }
}
