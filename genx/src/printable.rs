//! Text from files, made safe to print.

/// The text with its control characters escaped: names may hold anything, and must neither look like further lines nor reach the
/// terminal.
pub fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        if character.is_control() {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
    }
    shown
}
