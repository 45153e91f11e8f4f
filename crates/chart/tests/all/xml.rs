//! A tiny reader of XML.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// An element: name, attributes, text, children.
#[derive(Debug, Default)]
pub struct Element {
    pub name: String,
    attributes: Vec<(String, String)>,
    pub text: String,
    pub children: Vec<Element>,
}

impl Element {
    fn new(start: &BytesStart) -> Self {
        let attributes = start.attributes().map(|a| {
            let a = a.unwrap();
            let value = quick_xml::escape::unescape(&a.value).unwrap().into_owned();
            (a.key.as_ref().to_owned(), value)
        });
        Self { name: start.name().as_ref().to_owned(), attributes: attributes.collect(), ..Self::default() }
    }

    pub fn get(&self, key: &str) -> Option<&str> {
        self.attributes.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }

    pub fn number(&self, key: &str) -> f64 {
        let text = self.get(key).unwrap();
        assert!(text.chars().all(|c| c.is_ascii_digit() || c == '.' || c == '-'), "xsd:decimal: {text}");
        text.parse().unwrap()
    }

    pub fn all(&self, name: &str) -> Vec<&Element> {
        self.children.iter().filter(|c| c.name == name).collect()
    }

    pub fn one(&self, name: &str) -> &Element {
        let all = self.all(name);
        assert_eq!(all.len(), 1, "{name} in {}", self.name);
        all[0]
    }
}

/// The root of a document.
pub fn read(text: &str) -> Element {
    let mut reader = Reader::from_str(text);
    let mut open = vec![Element::default()];
    loop {
        match reader.read_event().unwrap() {
            Event::Start(e) => open.push(Element::new(&e)),
            Event::Empty(e) => open.last_mut().unwrap().children.push(Element::new(&e)),
            Event::End(_) => {
                let done = open.pop().unwrap();
                open.last_mut().unwrap().children.push(done);
            }
            Event::Text(t) => open.last_mut().unwrap().text += &t.xml10_content(),
            Event::GeneralRef(r) => {
                let name = r.into_inner();
                open.last_mut().unwrap().text += &quick_xml::escape::unescape(&format!("&{name};")).unwrap();
            }
            Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!(open.len(), 1);
    assert_eq!(open[0].children.len(), 1, "one root");
    open.remove(0).children.remove(0)
}
