//! GDAL's metadata of a GeoTIFF.

use chart::{DepthUnit, TiffMetadata};

#[test]
fn items_count_by_role_and_band() {
    let text = "<GDALMetadata>\n  <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">-2</Item>\n\
        <Item name=\"SCALE\" sample=\"1\" role=\"scale\">7</Item><Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.1</Item>\
        <Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">US survey foot</Item><Item name=\"scale\">9</Item></GDALMetadata>\n\0";
    let own = TiffMetadata::read(text).unwrap();
    assert_eq!((own.number("scale"), own.number("offset")), (Ok(Some(0.1)), Ok(Some(-2.0))));
    assert_eq!(own.unit(), Ok(Some(DepthUnit::SurveyFoot)));
    let none = TiffMetadata::read("").unwrap();
    assert_eq!((none.number("scale"), none.unit()), (Ok(None), Ok(None)));
    for cut in [12, 40, 80, 100] {
        assert!(TiffMetadata::read(&text[..cut]).is_err(), "{cut}");
    }
    let yards = TiffMetadata::read("<G><Item name=\"UNITTYPE\" role=\"unittype\">yd</Item></G>").unwrap();
    assert!(yards.unit().unwrap_err().to_string().contains("`yd`"));
}
