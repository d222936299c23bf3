# find_package(ltbw): the targets ltbw::ltbw, the shared library, and ltbw::static.

get_filename_component(ltbw_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET ltbw::ltbw)
  add_library(ltbw::ltbw SHARED IMPORTED)
  set_target_properties(ltbw::ltbw PROPERTIES
    IMPORTED_LOCATION "${ltbw_prefix}/lib/libltbw.so"
    INTERFACE_INCLUDE_DIRECTORIES "${ltbw_prefix}/include")
  add_library(ltbw::static STATIC IMPORTED)
  set_target_properties(ltbw::static PROPERTIES
    IMPORTED_LOCATION "${ltbw_prefix}/lib/libltbw.a"
    INTERFACE_INCLUDE_DIRECTORIES "${ltbw_prefix}/include"
    INTERFACE_LINK_LIBRARIES "m;pthread;dl")
endif()
