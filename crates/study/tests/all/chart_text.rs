//! Charts that are text, in any encoding.

use study::plan::chart_text;

#[test]
fn texts_are_read_by_their_marks() {
    let units: Vec<u16> = "aé€😀".encode_utf16().collect();
    let wide = |mark: [u8; 2], unit: fn(u16) -> [u8; 2]| {
        mark.into_iter().chain(units.iter().flat_map(|own| unit(*own))).collect::<Vec<u8>>()
    };
    let [little, big] = [wide([0xff, 0xfe], u16::to_le_bytes), wide([0xfe, 0xff], u16::to_be_bytes)];
    for bytes in ["aé€😀".into(), "\u{feff}aé€😀".into(), little.clone(), big] {
        assert_eq!(chart_text(bytes).as_deref(), Ok("aé€😀"));
    }
    assert!(chart_text(little[..little.len() - 1].to_vec()).unwrap_err().to_string().contains("cut off"));
    let bare: Vec<u8> = "x".repeat(40).encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(chart_text(bare).unwrap_err().to_string().contains("UTF-16 without"));
    assert!(chart_text(vec![0xff, 0xfe, 0, 0, 65, 0, 0, 0]).unwrap_err().to_string().contains("UTF-32"));
    assert!(chart_text(vec![0xff, 0]).unwrap_err().to_string().contains("UTF-8"));
}
