// The page of a report: one HTML file that needs nothing else, and its figures as files.
#pragma once
#include <string>
#include <vector>

#include "common/output.hpp"
#include "report/figure.hpp"

namespace cli {

// And what it means, as HTML.
struct Word {
    std::string name, meaning;
};

class Page {
  public:
    // A Failure where the folder's files cannot be written. It is made if need be, and removed again without write().
    explicit Page(const std::string &folder);
    // Names of figures that are added from now on begin with this.
    void set_prefix(const std::string &prefix) { prefix_ = prefix; }
    void add_title(const std::string &html);
    void add_heading(const std::string &html);
    void add_text(const std::string &html);
    // Drawn at once; a number behind its name where another has it.
    void add(Figure figure);
    // Cells are HTML; the first column is text, the others are numbers.
    void add_table(const std::string &caption, const std::vector<std::string> &heads,
                   const std::vector<std::vector<std::string>> &rows);
    // At the end of the page, each once.
    void explain(const std::vector<Word> &words);

    // All files or none, the page last; returns its path. Figures that the page which it replaces had, and this has
    // not, are removed.
    const std::string &write();

  private:
    struct Drawing {
        std::string name, svg, png;
    };
    std::string unique(const std::string &name) const;
    std::string glossary() const;

    OutputFolder folder_, inner_;
    std::string path_;
    OutputFile page_;
    std::string prefix_, title_, body_;
    std::vector<Drawing> figures_; // below figures/
    std::vector<Word> words_;
};

} // namespace cli
