# Writes the migrations into a C++ table, sorted by number:
#   cmake -DOUT=file.cpp -DSQL="a.sql;b.sql" -P embed_sql.cmake
list(SORT SQL)
set(rows "")
set(expected 1)
foreach(file ${SQL})
  get_filename_component(name ${file} NAME)
  if(NOT name MATCHES "^([0-9][0-9][0-9][0-9])_[a-z0-9_]+\\.sql$")
    message(FATAL_ERROR "${name}: a migration is named NNNN_words.sql")
  endif()
  math(EXPR number "1${CMAKE_MATCH_1} - 10000")
  if(NOT number EQUAL expected)
    message(FATAL_ERROR "${name}: expected number ${expected}; migrations have no holes")
  endif()
  math(EXPR expected "${expected} + 1")
  file(READ ${file} text)
  string(APPEND rows "    {${number}, \"${name}\", R\"lcrig_sql(${text})lcrig_sql\"},\n")
endforeach()
file(WRITE ${OUT} "// Generated from schema/sql by cmake/embed_sql.cmake.
#include \"storage/migrations.hpp\"

namespace lcrig {
namespace {
constexpr Migration kMigrations[] = {
${rows}};
}  // namespace
std::span<const Migration> shipped_migrations() {
  return kMigrations;
}
}  // namespace lcrig
")
