//! What points and commas are in the numbers of a table: decimal signs, or signs between thousands.
//!
//! A sign is a decimal sign where other than three digits follow it, or a zero leads it. It divides
//! thousands where it stands twice in a number, or where numbers of up to three digits stand
//! without it beside numbers with three digits behind it. Where neither is so, the other sign
//! decides: a table has one decimal sign.

/// The signs of a table's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Signs {
    pub decimal_comma: bool,
    /// The other sign divides thousands, also where it stands once.
    pub grouped: bool,
}

/// What the cells say of one sign.
#[derive(Clone, Debug, Default)]
struct Evidence<'a> {
    decimal: bool,
    thousands: bool,
    /// A number whose sign may be either.
    either: Option<&'a str>,
}

/// What the cells say of both signs.
#[derive(Clone, Debug)]
pub(crate) struct Evidences<'a> {
    point: Evidence<'a>,
    comma: Evidence<'a>,
}

impl<'a> Evidences<'a> {
    /// Of the cells of the columns, `column(k)` being those of the `k`-th.
    pub fn of(columns: &[Vec<&'a str>]) -> Self {
        let all = |sign, other| {
            columns.iter().map(|cells| of_column(cells, sign, other)).fold(Evidence::default(), |sum, own| Evidence {
                decimal: sum.decimal || own.decimal,
                thousands: sum.thousands || own.thousands,
                either: sum.either.or(own.either),
            })
        };
        Evidences { point: all('.', ','), comma: all(',', '.') }
    }

    /// The signs of the table where its decimal sign is a comma, or is not.
    pub fn signs(&self, decimal_comma: bool) -> Signs {
        let (own, other) = self.own_and_other(decimal_comma);
        let grouped = !other.decimal && (other.thousands || own.decimal);
        Signs { decimal_comma, grouped }
    }

    /// A comma is known to be a decimal sign.
    pub fn has_decimal_commas(&self) -> bool {
        self.comma.decimal
    }

    /// What is to be noted of numbers that may be read in two ways: `1.271` is 1271 where the comma
    /// is the decimal sign, and 1.271 where nothing tells.
    pub fn note(&self, signs: Signs, separator: u8) -> Option<String> {
        let (own, other) = self.own_and_other(signs.decimal_comma);
        let (own_name, other_name) = if signs.decimal_comma { ("comma", "point") } else { ("point", "comma") };
        if let Some(cell) = other.either.filter(|_| signs.grouped && !other.thousands) {
            let cell = super::printable(cell);
            return Some(format!(
                "the {own_name} is the decimal sign of this file: the {other_name} in `{cell}` divides thousands"
            ));
        }
        let silent = !own.decimal && !own.thousands && separator != b',';
        let cell = own.either.filter(|_| silent).map(super::printable)?;
        Some(format!(
            "the {own_name} in `{cell}` is read as the decimal sign; if it divides thousands, export without them"
        ))
    }

    fn own_and_other(&self, decimal_comma: bool) -> (&Evidence<'a>, &Evidence<'a>) {
        if decimal_comma { (&self.comma, &self.point) } else { (&self.point, &self.comma) }
    }
}

/// What one column says of `sign`, `other` being the other.
fn of_column<'a>(cells: &[&'a str], sign: char, other: char) -> Evidence<'a> {
    let mut evidence = Evidence::default();
    let (mut short, mut long) = (false, false);
    for cell in cells {
        let Some(mantissa) = mantissa(cell) else { continue };
        let parts: Vec<&str> = mantissa.split(sign).collect();
        match parts[..] {
            // three digits without a sign are told from thousands, one digit is not
            [whole] if digits(whole) => {
                short |= whole.len() == 3;
                long |= whole.len() > 3;
            }
            [_] => {}
            [whole, part] => match divided(whole, part, other, cell.trim().len() == mantissa_end(cell)) {
                Divided::Decimal => evidence.decimal = true,
                Divided::Thousands => evidence.thousands = true,
                Divided::Either => evidence.either = evidence.either.or(Some(cell)),
                Divided::Neither => {}
            },
            _ => evidence.thousands |= are_groups(&parts, other),
        }
    }
    evidence.thousands |= evidence.either.is_some() && short && !long && !evidence.decimal;
    evidence
}

enum Divided {
    Decimal,
    Thousands,
    Either,
    Neither,
}

/// What a sign between `whole` and `part` is; `alone`: no exponent follows.
fn divided(whole: &str, part: &str, other: char, alone: bool) -> Divided {
    if let Some((thousands, _)) = part.split_once(other) {
        return if thousands.len() == 3 && digits(whole) { Divided::Thousands } else { Divided::Neither };
    }
    if !digits(part) || !(whole.is_empty() || whole.chars().all(|c| c.is_ascii_digit() || c == other)) {
        return Divided::Neither;
    }
    let like_thousands = part.len() == 3 && (1..=3).contains(&whole.len()) && !whole.starts_with('0') && digits(whole);
    if like_thousands && alone { Divided::Either } else { Divided::Decimal }
}

/// Groups of three digits behind one of up to three; the last may have a decimal sign.
fn are_groups(parts: &[&str], other: char) -> bool {
    let last = parts.last().and_then(|part| part.split(other).next());
    let inner = parts[1..parts.len() - 1].iter().copied().chain(last);
    digits(parts[0]) && parts[0].len() <= 3 && inner.into_iter().all(|group| group.len() == 3 && digits(group))
}

fn digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// The digits and signs at the beginning of a number, without the sign of it; `None` of another
/// cell.
fn mantissa(cell: &str) -> Option<&str> {
    let text = cell.trim().trim_start_matches(['-', '+', '\u{2212}']);
    let end = text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | ','))).unwrap_or(text.len());
    let rest = text[end..].trim_start();
    let is_number = end > 0 && text.contains(|c: char| c.is_ascii_digit());
    // a unit or an exponent may follow, and no date
    (is_number && !rest.starts_with([':', '-', '/'])).then_some(&text[..end])
}

/// Bytes of a cell up to the end of its mantissa.
fn mantissa_end(cell: &str) -> usize {
    let cell = cell.trim();
    let signs = cell.len() - cell.trim_start_matches(['-', '+', '\u{2212}']).len();
    signs + mantissa(cell).map_or(0, str::len)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_other_sign_divides_thousands_where_one_is_known_to_be_decimal() {
        let signs = |columns: &[Vec<&str>], comma| Evidences::of(columns).signs(comma);
        let german = [vec!["915", "1.271"], vec!["0,00025", "0,00137"]];
        assert!(signs(&german, true).grouped);
        assert!(!signs(&[vec!["2.000", "2.003"]], true).grouped);
        assert!(signs(&[vec!["915", "1,271"]], false).grouped);
        assert!(!signs(&[vec!["0.010", "1.271"], vec!["0,5", "1,2"]], true).grouped);
        assert!(signs(&[vec!["1,234,567"]], false).grouped);
    }
}
