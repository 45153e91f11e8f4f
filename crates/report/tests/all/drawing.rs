//! Reads a drawing: its tags, and the corners of its paths.

/// Every tag is closed in order, attributes are quoted and unique, entities are known, nothing is outside the root.
pub fn check(svg: &str) {
    assert!(svg.starts_with("<svg role=\"img\" aria-label=\"") && svg.ends_with("</svg>\n"));
    let root = &svg[..svg.find('>').unwrap()];
    assert!(root.contains("viewBox=\"0 0 ") && !root.contains(" width="), "{root}");
    for wrong in ["NaN", "inf", " id=", "<style", "#000000"] {
        assert!(!svg.contains(wrong), "{wrong} in the drawing");
    }
    assert!(svg.chars().all(|c| c == '\n' || !c.is_control()));
    for (at, _) in svg.match_indices('&') {
        let known = ["&amp;", "&lt;", "&gt;", "&quot;"];
        assert!(known.iter().any(|entity| svg[at..].starts_with(entity)), "{}", &svg[at..at + 9]);
    }
    let mut open: Vec<&str> = Vec::new();
    for piece in svg.split('<').skip(1) {
        let (tag, after) = piece.split_once('>').expect("a tag is not closed");
        assert!(!after.contains('>'), "{after}");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else {
            attributes(tag);
            open.extend((!tag.ends_with('/')).then_some(name));
        }
        assert!(!open.is_empty() || after == "\n");
    }
    assert!(open.is_empty(), "{open:?}");
}

fn attributes(tag: &str) {
    let pieces: Vec<&str> = tag.split('"').collect();
    assert!(pieces.len() % 2 == 1, "{tag}");
    let mut names: Vec<&str> =
        pieces[..pieces.len() - 1].iter().step_by(2).map(|piece| piece.trim()).collect();
    assert!(names.iter().all(|name| name.ends_with('=')), "{tag}");
    names.sort_unstable();
    let count = names.len();
    names.dedup();
    assert_eq!(names.len(), count, "{tag}");
}

/// Value of a numeric attribute of a tag.
pub fn attribute(tag: &str, name: &str) -> i64 {
    let key = format!(" {name}=\"");
    let from = tag.find(&key).unwrap_or_else(|| panic!("no {name} in {tag}")) + key.len();
    tag[from..].split('"').next().unwrap().parse().unwrap()
}

/// x, y, width, height of the map's frame: the only rectangle that is not filled above the scale bar.
pub fn frame(svg: &str) -> [i64; 4] {
    let tag = elements(svg, "rect").next().unwrap();
    ["x", "y", "width", "height"].map(|name| attribute(tag, name))
}

/// Tags of one kind.
pub fn elements<'a>(svg: &'a str, kind: &str) -> impl Iterator<Item = &'a str> {
    let start = format!("{kind} ");
    svg.split('<').filter(move |piece| piece.starts_with(&start))
}

/// The rings and lines of a path, in units of the sheet.
pub fn corners(path: &str) -> Vec<Vec<(i64, i64)>> {
    let from = path.find(" d=\"").unwrap() + 4;
    let data = path[from..].split('"').next().unwrap();
    data.split('M').skip(1).map(one).collect()
}

fn one(data: &str) -> Vec<(i64, i64)> {
    let data = data.trim_end_matches('z').replace("h1", "l1 0");
    let data = data.replace('l', " ").replace('-', " -");
    let numbers: Vec<i64> = data.split_whitespace().map(|number| number.parse().unwrap()).collect();
    let mut at = (0, 0);
    let step = |pair: &[i64]| {
        at = (at.0 + pair[0], at.1 + pair[1]);
        at
    };
    numbers.chunks(2).map(step).collect()
}

/// Twice the area of rings, positive if they run clockwise on the sheet.
pub fn doubled_area(rings: &[Vec<(i64, i64)>]) -> i64 {
    let one = |ring: &Vec<(i64, i64)>| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<i64>()
    };
    rings.iter().map(one).sum()
}
