"""A page of HTML as a parser sees its attributes."""

from html.parser import HTMLParser


class Reader(HTMLParser):
    """The attributes of a page."""

    def __init__(self, text):
        super().__init__()
        self.attributes = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        """Keep them."""
        self.attributes += attributes

    def of(self, *names):
        """The values of attributes with one of the names, in the order of the page."""
        return [value for name, value in self.attributes if name in names]
