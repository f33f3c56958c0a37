// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The C library's locale of a Turkish program, in which std::tolower('I') is not 'i'. */

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <unistd.h>

namespace programs::test {

/* Sets the locale until it is destroyed. Compiles it with localedef, because few machines have it installed. */
class TurkishLocale {
public:
  TurkishLocale() : folder(std::filesystem::temp_directory_path() / ("cbvh_locale_" + std::to_string(getpid()))) {
    std::filesystem::create_directory(folder);
    const std::string command = "localedef -i tr_TR -f UTF-8 " + (folder / name).string() + " > /dev/null 2>&1";
    if (std::system(command.c_str()) != 0) return;
    setenv("LOCPATH", folder.c_str(), 1);
    isSet = std::setlocale(LC_CTYPE, name) != nullptr;
  }

  ~TurkishLocale() {
    std::setlocale(LC_CTYPE, "C");
    unsetenv("LOCPATH");
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
  }

  TurkishLocale(const TurkishLocale&) = delete;
  TurkishLocale& operator=(const TurkishLocale&) = delete;

  /* False if this machine has no localedef or no source of the locale. */
  explicit operator bool() const { return isSet; }

private:
  static constexpr const char* name = "tr_TR.UTF-8";

  std::filesystem::path folder;
  bool isSet = false;
};

} // namespace programs::test
