#include "report/page.hpp"

#include <algorithm>
#include <memory>

#include "common/terminal.hpp"
#include "report/words.hpp"

namespace cli {

namespace {

constexpr const char *kStyle = R"(
body { margin: 0; background: #fff; color: #222; font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; }
main { max-width: 900px; margin: 2.5em auto; padding: 0 1em; }
h1 { font-size: 1.7em; margin: 2em 0 0.2em; } h1:first-child { margin-top: 0; }
h2 { font-size: 1.2em; margin: 2.2em 0 0.4em; border-bottom: 1px solid #ddd; }
p { margin: 0.5em 0; }
figure { margin: 1.5em 0; } figure img { display: block; width: 100%; height: auto; }
figcaption, caption { font-size: 0.9em; color: #444; text-align: left; margin-top: 0.4em; }
caption { padding-bottom: 0.4em; }
table { border-collapse: collapse; margin: 1.5em 0; font-size: 0.92em; }
th, td { padding: 0.25em 0.9em; text-align: right; border-bottom: 1px solid #e4e4e4; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
thead th { border-bottom: 2px solid #888; }
dl { font-size: 0.9em; color: #444; } dt { font-weight: bold; margin-top: 0.5em; } dd { margin: 0 0 0 1.5em; }
@media print { main { margin: 0 auto; } figure, table { break-inside: avoid; } }
)";

std::string row_of(const std::vector<std::string> &cells, const char *tag) {
    std::string text = "<tr>";
    for (const std::string &cell : cells)
        text += printed("<%s>", tag) + cell + printed("</%s>", tag);
    return text + "</tr>\n";
}

} // namespace

Page::Page(const std::string &folder)
    : folder_(folder), inner_(folder_.file("figures")), path_(folder_.file("report.html")), page_(path_) {}

void Page::add_title(const std::string &html) {
    if (title_.empty())
        title_ = html;
    body_ += "<h1>" + html + "</h1>\n";
}

void Page::add_heading(const std::string &html) {
    body_ += "<h2>" + html + "</h2>\n";
}

void Page::add_text(const std::string &html) {
    body_ += "<p>" + html + "</p>\n";
}

void Page::add(Figure figure) {
    stop_if_asked();
    figure.name = prefix_ + figure.name;
    const std::string svg = drawn(figure, FileKind::svg);
    body_ += "<figure id=\"" + escaped(figure.name) + "\">\n<img alt=\"" + escaped(figure.name) +
             printed("\" width=\"%d\" height=\"%d\" src=\"data:image/svg+xml;base64,", kFigureWidth, figure.height) +
             base64(svg) + "\">\n<figcaption>" + figure.caption + "</figcaption>\n</figure>\n";
    figures_.push_back({figure.name + ".svg", svg});
    figures_.push_back({figure.name + ".png", drawn(figure, FileKind::png)});
}

void Page::add_table(const std::string &caption, const std::vector<std::string> &heads,
                     const std::vector<std::vector<std::string>> &rows) {
    body_ += "<table>\n<caption>" + caption + "</caption>\n<thead>" + row_of(heads, "th") + "</thead>\n<tbody>\n";
    for (const std::vector<std::string> &row : rows)
        body_ += row_of(row, "td");
    body_ += "</tbody>\n</table>\n";
}

void Page::explain(const std::vector<Word> &words) {
    for (const Word &word : words)
        if (std::none_of(words_.begin(), words_.end(), [&](const Word &known) { return known.name == word.name; }))
            words_.push_back(word);
}

std::string Page::glossary() const {
    if (words_.empty())
        return "";
    std::string html = "<h2>Words</h2>\n<dl>\n";
    for (const Word &word : words_)
        html += "<dt>" + word.name + "</dt><dd>" + word.meaning + "</dd>\n";
    return html + "</dl>\n";
}

const std::string &Page::write() {
    std::vector<std::unique_ptr<OutputFile>> files;
    for (const File &figure : figures_) {
        files.push_back(std::make_unique<OutputFile>(inner_.file(figure.name)));
        files.back()->write(figure.bytes.data(), figure.bytes.size());
    }
    const std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                             "<meta name=\"viewport\" content=\"width=device-width\">\n<title>" +
                             title_ + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<main>\n" + body_ +
                             glossary() + "</main>\n</body>\n</html>\n";
    page_.write(html.data(), html.size());
    for (const std::unique_ptr<OutputFile> &file : files)
        file->commit();
    page_.commit(); // last: whoever finds it finds its figures
    inner_.keep();
    folder_.keep();
    return path_;
}

} // namespace cli
