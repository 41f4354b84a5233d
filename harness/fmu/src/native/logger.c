// The logger of FMI 2.0 takes a format and its arguments, as printf does, which Rust cannot read.
#include <stdarg.h>
#include <stdio.h>

void hil_fmi2_log(void *environment, int status, const char *text);

void hil_fmi2_logger(void *environment, const char *instance, int status, const char *category, const char *format, ...) {
    (void)instance;
    (void)category;
    char text[2048] = "";
    va_list arguments;
    va_start(arguments, format);
    if (format) vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    hil_fmi2_log(environment, status, text);
}
