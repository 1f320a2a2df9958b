//! Control characters of files, made visible: a terminal obeys none of them.

use std::borrow::Cow;

const SHOWN: char = '\u{fffd}';

/// Characters of a line of a file that a report shows.
const SNIPPET_MAX: usize = 200;

/// A report whose lines from a file (behind `│`, and the marks below them) are cut where they are
/// long: a file of one line does not fill the terminal. Of several errors each begins with its
/// mark, so that no line says `Error:` alone.
pub fn cut_snippets(report: &str) -> String {
    let is_snippet = |line: &str| line.chars().take(20).any(|c| matches!(c, '│' | '·'));
    let cut = |line: &str| match line.char_indices().nth(SNIPPET_MAX) {
        Some((at, _)) if is_snippet(line) => format!("{}…\n", &line[..at]),
        _ => format!("{line}\n"),
    };
    report.lines().filter(|line| line.trim() != "Error:").map(cut).collect()
}

/// Moves a cursor, changes colours or turns the direction of reading.
fn commands(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && c != '\n' && c != '\t')
}

/// `text` with a mark for every control character but line ends and tabulators.
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(commands) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.chars().map(|c| if commands(c) { SHOWN } else { c }).collect())
}

/// As [`visible`]; on a terminal the colours of a report stay.
pub fn visible_but_colours(text: &str) -> Cow<'_, str> {
    use std::io::IsTerminal;
    if !std::io::stderr().is_terminal() { visible(text) } else { with_colours(text) }
}

fn with_colours(text: &str) -> Cow<'_, str> {
    if !text.contains(commands) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(commands) {
        shown.push_str(&rest[..at]);
        rest = &rest[at..];
        let colour = colour(rest);
        let taken = if colour > 0 { colour } else { rest.chars().next().map_or(1, char::len_utf8) };
        if colour > 0 {
            shown.push_str(&rest[..colour])
        } else {
            shown.push(SHOWN)
        }
        rest = &rest[taken..];
    }
    shown.push_str(rest);
    Cow::Owned(shown)
}

/// Bytes of the colour that `text` begins with.
fn colour(text: &str) -> usize {
    let Some(numbers) = text.strip_prefix("\u{1b}[") else { return 0 };
    let end = numbers.find(|c: char| !c.is_ascii_digit() && c != ';');
    end.filter(|at| numbers[*at..].starts_with('m')).map_or(0, |at| at + 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_seen() {
        assert_eq!(visible("a\u{1b}[2Jb\r\u{9b}\u{202e}\n\t"), "a\u{fffd}[2Jb\u{fffd}\u{fffd}\u{fffd}\n\t");
        assert!(matches!(visible("plain, µ and \n"), Cow::Borrowed(_)));
    }

    #[test]
    fn several_errors_have_no_line_that_says_nothing_between_them() {
        assert_eq!(
            cut_snippets("x one\nError: \n  x two\n  help: Error: three"),
            "x one\n  x two\n  help: Error: three\n"
        );
    }

    #[test]
    fn colours_of_a_report_stay_and_nothing_else_does() {
        let text = "\u{1b}[31;1mred\u{1b}[0m \u{1b}[2J\u{1b}]0;title\u{7}";
        assert_eq!(with_colours(text), "\u{1b}[31;1mred\u{1b}[0m \u{fffd}[2J\u{fffd}]0;title\u{fffd}");
    }
}
