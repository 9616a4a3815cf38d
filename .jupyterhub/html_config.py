"""For `jupyter nbconvert --to html`: links lead to the published lessons, and solutions are left out."""

import re

from nbconvert.preprocessors import Preprocessor, TagRemovePreprocessor

c = get_config()  # noqa: F821


class LinkLessons(Preprocessor):
    """Turn links to neighbouring notebooks into links to neighbouring pages, in text and in outputs."""

    def preprocess_cell(self, cell, resources, _index):
        if cell.cell_type == "markdown":
            cell.source = self.relink(cell.source)
        for output in cell.get("outputs", []):
            for kind in {"text/html", "text/markdown"} & output.get("data", {}).keys():
                output.data[kind] = self.relink(output.data[kind])
        return cell, resources

    def relink(self, text):
        return re.sub(r"""((?:\]\(|href=["'])[^)"':\s]+)\.ipynb(?=[)"'#])""", r"\1.html", text)


c.HTMLExporter.preprocessors = [LinkLessons, TagRemovePreprocessor]
c.TagRemovePreprocessor.remove_cell_tags = {"solution"}
