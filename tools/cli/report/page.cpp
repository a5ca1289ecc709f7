#include "report/page.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <unistd.h>

#include "common/content.hpp"
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

constexpr const char *kFigureTag = "<figure id=\"";

// What follows it.
std::string picture_of(const std::string &name) {
    return name + "\">\n<img alt=\"" + name + "\" width=\"";
}

bool is_of_name(char letter) {
    return (letter >= '0' && letter <= '9') || (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
           letter == '-';
}

// For files.
std::string plain_name(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char letter) { return !is_of_name(letter); }, '-');
    return text;
}

// Names of the figures of a page that another report left; none where it is something else.
std::vector<std::string> figures_of(const std::string &path) {
    std::vector<std::string> names;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        return names;
    std::ifstream file(path, std::ios::binary);
    const std::string page{std::istreambuf_iterator<char>(file), {}}, tag = kFigureTag;
    for (size_t at = page.find(tag); at != std::string::npos; at = page.find(tag, at)) {
        at += tag.size();
        const std::string name = page.substr(at, std::min(page.find('"', at), page.size()) - at);
        const std::string rest = picture_of(name);
        if (!name.empty() && name == plain_name(name) && page.compare(at, rest.size(), rest) == 0)
            names.push_back(name);
    }
    return names;
}

std::string row_of(const std::vector<std::string> &cells, const char *tag) {
    std::string text = "<tr>";
    for (const std::string &cell : cells)
        text += printed("<%s>", tag) + cell + printed("</%s>", tag);
    return text + "</tr>\n";
}

} // namespace

Page::Page(const std::string &folder)
    : folder_(folder), inner_(folder_.file("figures")), path_(folder_.file("report.html")),
      page_(path_, figures_of(path_).empty() ? Replaces::results : Replaces::anything) {}

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

std::string Page::unique(const std::string &name) const {
    const auto is_free = [&](const std::string &tried) {
        return std::none_of(figures_.begin(), figures_.end(),
                            [&](const Drawing &known) { return known.name == tried; });
    };
    std::string tried = name;
    for (int i = 2; !is_free(tried); i++)
        tried = name + "-" + std::to_string(i);
    return tried;
}

void Page::add(Figure figure) {
    stop_if_asked();
    figure.name = unique(plain_name(prefix_ + figure.name));
    const std::string svg = drawn(figure, FileKind::svg);
    body_ += kFigureTag + picture_of(figure.name) +
             printed("%d\" height=\"%d\" src=\"data:image/svg+xml;base64,", kFigureWidth, figure.height) + base64(svg) +
             "\">\n<figcaption>" + figure.caption + "</figcaption>\n</figure>\n";
    figures_.push_back({figure.name, svg, drawn(figure, FileKind::png)});
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
    const std::vector<std::string> before = figures_of(path_);
    std::vector<std::unique_ptr<OutputFile>> files;
    const auto put = [&](const std::string &figure, const char *suffix, const std::string &bytes) {
        const bool is_own = std::find(before.begin(), before.end(), figure) != before.end();
        files.push_back(std::make_unique<OutputFile>(inner_.file(figure + suffix),
                                                     is_own ? Replaces::anything : Replaces::results));
        files.back()->write(bytes.data(), bytes.size());
        files.back()->close(); // there may be more figures than a process may have files
    };
    for (const Drawing &figure : figures_) {
        put(figure.name, ".svg", figure.svg);
        put(figure.name, ".png", figure.png);
    }
    const std::string html = std::string(kPageMark) +
                             "<meta name=\"viewport\" content=\"width=device-width\">\n<title>" + title_ +
                             "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<main>\n" + body_ + glossary() +
                             "</main>\n</body>\n</html>\n";
    page_.write(html.data(), html.size());
    for (const std::unique_ptr<OutputFile> &file : files)
        file->commit();
    page_.commit(); // last: whoever finds it finds its figures
    for (const std::string &name : before)
        if (unique(name) == name)
            for (const char *suffix : {".svg", ".png"})
                ::unlink(inner_.file(name + suffix).c_str());
    inner_.keep();
    folder_.keep();
    return path_;
}

} // namespace cli
