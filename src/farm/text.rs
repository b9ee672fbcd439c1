//! Text that strangers give and people read.

/// Whether a character is none to be seen: it controls a terminal, or it has no width and joins nothing, or it turns the order of the text after it, so that one name
/// looks like another (Unicode Technical Report 36, 2.6 and 3.5).
pub(super) fn is_hidden(character: char) -> bool {
    let has_no_width = matches!(character, '\u{200b}' | '\u{2060}'..='\u{2065}' | '\u{feff}');
    let turns_text =
        matches!(character, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{206f}');
    character.is_control() || has_no_width || turns_text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_all_scripts_are_seen_and_tricks_are_not() {
        assert!(!"Küche 3, ночь, 夜, ليل, 👩 — “final”".chars().any(is_hidden));
        for hidden in ['\n', '\u{1b}', '\u{202e}', '\u{2066}', '\u{200b}', '\u{feff}'] {
            assert!(is_hidden(hidden), "{hidden:?}");
        }
    }
}
