//! From bytes to text, whatever encoding they are in.

use chardetng::{EncodingDetector, Iso2022JpDetection, Utf8Detection};
use encoding_rs::{Encoding, SHIFT_JIS, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use crate::error::Error;

/// A text and the name of its encoding.
pub(crate) fn decode(bytes: &[u8], given: Option<&str>) -> Result<(String, &'static str), Error> {
    let encoding = match given {
        Some(name) => Encoding::for_label(name.as_bytes()).ok_or_else(|| {
            Error::new(
                format!("the encoding \"{name}\" is unknown"),
                "name one of the Encoding Standard, such as utf-8, utf-16le, windows-1252 or shift_jis",
            )
        })?,
        None => guess(bytes),
    };
    // a byte order mark is taken off, and wins
    let (text, encoding, _) = encoding.decode(bytes);
    Ok((text.into_owned(), encoding.name()))
}

fn guess(bytes: &[u8]) -> &'static Encoding {
    if let Some((encoding, _)) = Encoding::for_bom(bytes) {
        return encoding;
    }
    // text of numbers in UTF-16: every other byte is 0
    let sample = &bytes[..bytes.len().min(4096)];
    let zeros = |from: usize| sample.iter().skip(from).step_by(2).filter(|b| **b == 0).count() * 4 > sample.len();
    match (zeros(0), zeros(1)) {
        (false, true) => return UTF_16LE,
        (true, false) => return UTF_16BE,
        _ => {}
    }
    if std::str::from_utf8(bytes).is_ok() {
        return UTF_8;
    }
    let mut detector = EncodingDetector::new(Iso2022JpDetection::Allow);
    detector.feed(bytes, true);
    let likely = detector.guess(None, Utf8Detection::Allow);
    // tables have few letters to go by: what reads as the words and marks of measurements is right
    let mut best = (0, likely);
    for encoding in [likely, WINDOWS_1252, SHIFT_JIS] {
        let (text, _, broken) = encoding.decode(bytes);
        let marks = if broken { 0 } else { 1 + text.chars().take(20_000).filter(|c| is_measurements(*c)).count() };
        if marks > best.0 {
            best = (marks, encoding);
        }
    }
    best.1
}

/// Signs that stand in tables of measurements and hardly ever come of a wrong decoding.
fn is_measurements(c: char) -> bool {
    matches!(
        c,
        '°' | 'µ'
            | 'Ω'
            | '²'
            | '³'
            | '±'
            | 'ä'
            | 'ö'
            | 'ü'
            | 'Ä'
            | 'Ö'
            | 'Ü'
            | 'ß'
            | 'é'
            | 'è'
            | 'ê'
            | 'à'
            | 'ç'
            | 'ô'
            | 'î'
            | '℃'
    ) || "時間秒電圧流力荷重温度変位伸縮長抵抗位置室試験片計測値周囲回数番号線単位日付".contains(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_told_apart() {
        let german = "Zeit [s];Weg [µm];Temperatur [°C]\n0;1;2\n";
        let japanese = "時間(s),電流(A),変位(mm)\n0,1,2\n";
        let french = "temps (s);déplacement (mm);température (°C)\n0;1;2\n";
        for (text, encoding) in [
            (german, WINDOWS_1252),
            (french, WINDOWS_1252),
            (german, UTF_8),
            (japanese, SHIFT_JIS),
            (japanese, UTF_8),
            (japanese, encoding_rs::EUC_JP),
        ] {
            let (bytes, ..) = encoding.encode(text);
            assert_eq!(decode(&bytes, None), Ok((text.to_string(), encoding.name())), "{}", encoding.name());
        }
        for text in [german, japanese] {
            let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
            let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
            assert_eq!(decode(&[b"\xff\xfe", &little[..]].concat(), None).unwrap().0, text);
            assert_eq!(decode(&[b"\xfe\xff", &big[..]].concat(), None).unwrap().0, text);
            let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
            assert_eq!(decode(&marked, None).unwrap().0, text);
        }
        let numbers = "time;load\n0.00;1.25\n0.01;1.26\n";
        let little: Vec<u8> = numbers.encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(decode(&little, None), Ok((numbers.to_string(), "UTF-16LE")), "without a mark");
        assert!(decode(b"", Some("klingon")).unwrap_err().message.contains("klingon"));
    }
}
