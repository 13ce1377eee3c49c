/// Writes the shell completion and manual pages of the command line from its own description: pages
/// FOLDER. The folder receives man1/sightline.1, a page per command, and the completion for bash,
/// `sightline`.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "cli/arguments.hpp"
#include "sightline/config.hpp"

namespace sightline::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view exit_codes =
    ".SH EXIT STATUS\n"
    ".TP\n.B 0\nDone.\n"
    ".TP\n.B 1\nThe flight failed, or output was lost.\n"
    ".TP\n.B 2\nBad input.\n";

/// Text escaped for roff: hyphens that can be copied, and no line that begins a request.
std::string roff(std::string_view text) {
  std::string printed;
  for (const char c : text) {
    if (c == '-') {
      printed += "\\-";
    } else if (c == '\\') {
      printed += "\\e";
    } else if ((c == '.' || c == '\'') && (printed.empty() || printed.back() == '\n')) {
      printed += "\\&";
      printed += c;
    } else {
      printed += c;
    }
  }
  return printed;
}

bool is_positional(const CLI::Option& option) { return option.get_positional(); }
bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

std::vector<const CLI::Option*> options_of(const CLI::App& app, bool positional) {
  std::vector<const CLI::Option*> options;
  for (const CLI::Option* option : app.get_options())
    if (is_positional(*option) == positional) options.push_back(option);
  return options;
}

/// The names of an option as typed: "-o", "--output".
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

std::string head(std::string_view title, std::string_view purpose) {
  std::string upper(title);
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return fmt::format(".TH {} 1 \"\" \"sightline {}\" \"sightline\"\n.SH NAME\n{} \\- {}\n", roff(upper),
                     sightline::version, roff(title), roff(purpose));
}

std::string entry(const CLI::Option& option) {
  std::string words;
  for (const std::string& name : names_of(option)) {
    if (!words.empty()) words += ", ";
    words += "\\fB" + roff(name) + "\\fR";
  }
  if (is_positional(option)) words = "\\fI" + roff(option.get_name(true)) + "\\fR";
  if (!is_positional(option) && takes_value(option)) words += " \\fIVALUE\\fR";
  std::string text = roff(option.get_description());
  if (!option.get_default_str().empty()) text += " [" + roff(option.get_default_str()) + "]";
  return fmt::format(".TP\n{}\n{}\n", words, text);
}

std::string command_page(const CLI::App& command) {
  const std::string title = "sightline-" + command.get_name();
  std::string text = head(title, command.get_description());
  text += fmt::format(".SH SYNOPSIS\n\\fBsightline {}\\fR", roff(command.get_name()));
  for (const CLI::Option* option : options_of(command, true))
    text += fmt::format(" \\fI{}\\fR", roff(option->get_name(true)));
  text += " [\\fIOPTIONS\\fR]\n.SH OPTIONS\n";
  for (const bool positional : {true, false})
    for (const CLI::Option* option : options_of(command, positional)) text += entry(*option);
  return text + std::string(exit_codes) + ".SH SEE ALSO\n.BR sightline (1)\n";
}

std::string main_page(const CLI::App& app) {
  std::string text = head("sightline", "nonlinear model predictive control of coupled robots");
  text += ".SH SYNOPSIS\n\\fBsightline\\fR \\fICOMMAND\\fR [\\fIOPTIONS\\fR]\n.SH DESCRIPTION\n" +
          roff(app.get_description()) + "\n.SH COMMANDS\n";
  std::string also;
  for (const CLI::App* command : app.get_subcommands({})) {
    text += fmt::format(".TP\n\\fB{}\\fR\n{}\n", roff(command->get_name()), roff(command->get_description()));
    also += fmt::format("{}.BR sightline\\-{} (1)", also.empty() ? "" : ",\n", roff(command->get_name()));
  }
  text += ".SH OPTIONS\n";
  for (const CLI::Option* option : options_of(app, false)) text += entry(*option);
  return text + std::string(exit_codes) + ".SH SEE ALSO\n" + also + "\n";
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

/// Completes commands first; then options of a command after a dash, else files: scenarios, where
/// it takes one.
std::string completion(const CLI::App& app) {
  std::vector<std::string> commands;
  std::string cases;
  for (const CLI::App* command : app.get_subcommands({})) {
    commands.push_back(command->get_name());
    std::vector<std::string> words;
    for (const CLI::Option* option : options_of(*command, false))
      for (std::string& name : names_of(*option)) words.push_back(std::move(name));
    std::string files = "none";
    for (const CLI::Option* option : options_of(*command, true))
      files = option->get_name(true) == "SCENARIO" ? "scenarios" : "folders";
    cases += fmt::format("    {}) options=\"{}\" files={} ;;\n", command->get_name(), joined(words), files);
  }
  std::vector<std::string> of_all;
  for (const CLI::Option* option : options_of(app, false))
    for (std::string& name : names_of(*option)) of_all.push_back(std::move(name));
  return fmt::format(R"(# Completion of sightline for bash, made from its own description.
_sightline() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} options files
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "{} {}" -- "$word")
    return
  fi
  case ${{COMP_WORDS[1]}} in
{}    *) return ;;
  esac
  case ${{COMP_WORDS[COMP_CWORD - 1]}} in
    -o | --output) files=folders ;;
    --compare-with) files=scenarios ;;
    *)
      if [[ $word == -* ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
        return
      fi
      ;;
  esac
  [[ $files == none ]] && return
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen -d -- "$word")
  [[ $files == folders ]] && return
  mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -f -X '!*.toml' -- "$word")
}}
complete -F _sightline sightline
)",
                     joined(commands), joined(of_all), cases);
}

void write(const fs::path& file, std::string_view text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file.string() + ": not written, expected a folder that takes it");
}

void write_pages(const fs::path& folder) {
  const Arguments words;
  fs::create_directories(folder / "man1");
  write(folder / "man1" / "sightline.1", main_page(words.app));
  for (const CLI::App* command : words.app.get_subcommands({}))
    write(folder / "man1" / ("sightline-" + command->get_name() + ".1"), command_page(*command));
  write(folder / "sightline", completion(words.app));
}

}  // namespace
}  // namespace sightline::cli

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "pages: %d arguments, expected FOLDER\n", argc - 1);
    return 2;
  }
  try {
    sightline::cli::write_pages(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pages: %s\n", error.what());
    return 1;
  }
  return 0;
}
