# find_package(sinew) gives sinew::sinew (the shared library) and sinew::static, with their headers, for C and C++17.
get_filename_component(SINEW_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET sinew::sinew)
  add_library(sinew::sinew SHARED IMPORTED)
  set_target_properties(sinew::sinew PROPERTIES
    IMPORTED_LOCATION "${SINEW_PREFIX}/lib/libsinew.so.@ABI@"
    IMPORTED_SONAME "libsinew.so.@ABI@"
    INTERFACE_INCLUDE_DIRECTORIES "${SINEW_PREFIX}/include")

  add_library(sinew::static STATIC IMPORTED)
  set_target_properties(sinew::static PROPERTIES
    IMPORTED_LOCATION "${SINEW_PREFIX}/lib/libsinew.a"
    INTERFACE_INCLUDE_DIRECTORIES "${SINEW_PREFIX}/include"
    # what the standard library of Rust asks of the system
    INTERFACE_LINK_LIBRARIES "gcc_s;util;rt;pthread;m;dl")
endif()

set(sinew_FOUND TRUE)
