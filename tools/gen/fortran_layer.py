"""Writes the object layer of Fortran: a derived type per handle with type-bound procedures around its functions.

A procedure that toliman.f90.in defines under the name that it would have here is bound but not generated.
"""
import re

from fortran import base_type, declarations, flowing, first_sentence, listed, result, wrapped
from model import Callback, Function, Handle, Struct

# Names of the derived types, without toliman_.
TYPES = {"toliman_sim": "simulator", "toliman_cae": "autoencoder", "toliman_linear": "linear_estimator",
         "toliman_fit": "frame_fit", "toliman_bank": "network_bank",
         "toliman_calibration": "scene_calibration", "toliman_coadd": "frame_adder", "toliman_components": "component_set", "toliman_mask": "phase_mask",
         "toliman_ingest": "pair_reader", "toliman_measure": "measurements", "toliman_period": "periodogram", "toliman_planet": "planet_set",
         "toliman_series": "series_parser", "toliman_sky": "sky_predictor", "toliman_track": "tracker"}

STATUS_ARGUMENTS = ["integer, intent(out), optional :: stat",
          "character(len=*), intent(inout), optional :: errmsg"]


class Layer:
    """All derived types and their procedures."""

    def __init__(self, model, template):
        self.model = model
        self.handwritten = re.findall(r"^    subroutine (\w+)\((.*)\)", template, re.M)
        self.bindings = {handle.name: [] for handle in model.all(Handle)}
        self.procedures = ""
        for name in self.bindings:
            if name not in TYPES:
                raise SystemExit(f"tools/gen/fortran_layer.py: {name} has no name among TYPES")
        for item in model.all(Function):
            self.bind(item)
        for name, arguments in self.handwritten:
            self.bind_handwritten(name, arguments.startswith("self"))

    # Assignment of functions to types.

    def handle_of(self, argument):
        """Returns the name of an argument's handle type, None if it is not a handle."""
        return argument.type.base if self.model.kind(argument.type.base) is Handle else None

    def info_of(self, handle, name):
        """Returns the _info function and struct that have a property of an object, such as the rows of its frames."""
        for item in self.model.all(Function):
            if re.search(r"_get_\w*info$", item.name) and self.handle_of(item.arguments[0]) == handle:
                struct = self.model.by_name[item.arguments[-1].type.base]
                if any(field.name == name for field in struct.fields):
                    return item.name, struct.name
        return None

    def owner(self, item):
        """Returns the handle that a function is bound to, None if there is none, and whether the function creates an
        object of this handle."""
        handles = [self.handle_of(argument) for argument in item.arguments] or [None]
        last = item.arguments[-1].type if item.arguments else None
        if handles[-1] and last.pointers == 2 and not last.const and handles[0] != handles[-1]:
            return handles[-1], True
        return handles[0] or self.module_of(item), False

    def module_of(self, item):
        """Returns the handle whose name prefixes a function: toliman_sim for toliman_sim_plan_file."""
        return min((handle for handle in TYPES if item.name.startswith(handle + "_")), key=len,
                   default=None)

    def bind(self, item):
        """Writes the procedure of a function, unless the function has no object or is a _destroy."""
        owner, creator = self.owner(item)
        if owner is None or "_destroy" in item.name:
            return
        module = self.module_of(item)
        prefix = module if owner == module else "toliman"
        binding = item.name[len(prefix) + 1:]
        bound = creator or (bool(item.arguments) and self.handle_of(item.arguments[0]) == owner)
        self.bindings[owner].append((binding, bound))
        if f"{TYPES[owner]}_{binding}" not in dict(self.handwritten):
            self.procedures += Procedure(self, item, owner, binding, bound, creator).write() + "\n"

    def bind_handwritten(self, name, bound):
        """Binds a handwritten procedure that corresponds to no single C function."""
        for handle, short in TYPES.items():
            binding = name[len(short) + 1:]
            if name.startswith(short + "_") and (binding, bound) not in self.bindings[handle]:
                self.bindings[handle].append((binding, bound))

    # Derived types.

    def has_frames(self, handle):
        """Returns whether arrays of a handle's functions have the shape of its frames."""
        return any(extent in ("rows", "cols") for item in self.model.all(Function)
                   for argument in item.arguments for extent in argument.extents
                   if self.handle_of(item.arguments[0]) == handle)

    def type(self, handle):
        short = TYPES[handle.name]
        text = flowing(handle.doc, 4) + f"    type, public :: toliman_{short}\n"
        text += "        type(c_ptr) :: handle = c_null_ptr\n"
        if self.has_frames(handle.name):
            text += "        integer(c_size_t), private :: rows = -1, cols = -1 ! of a frame\n"
        text += "    contains\n"
        for binding, bound in self.bindings[handle.name]:
            text += f"        procedure{'' if bound else ', nopass'} :: {binding} => {short}_{binding}\n"
        text += f"        procedure :: destroy => {short}_destroy\n        procedure, private :: {short}_assign\n"
        text += f"        generic :: assignment(=) => {short}_assign\n        final :: {short}_final\n    end type\n"
        return text

    def types(self):
        return "\n".join(self.type(handle) for handle in self.model.all(Handle))

    def lifecycle(self):
        """Returns destroy, finaliser and the rejected assignment of every type."""
        text = ""
        for handle in self.model.all(Handle):
            short = TYPES[handle.name]
            destroy = next(item for item in self.model.all(Function) if "_destroy" in item.name
                           and item.arguments[0].type.base == handle.name)
            forget = "        self%rows = -1\n        self%cols = -1\n" if self.has_frames(handle.name) else ""
            text += f"""\
    ! Destroys the object; create may be called again.
    impure elemental subroutine {short}_destroy(self)
        class(toliman_{short}), intent(inout) :: self
        call {destroy.name}(self%handle)
        self%handle = c_null_ptr
{forget}    end subroutine

    impure elemental subroutine {short}_final(self)
        type(toliman_{short}), intent(inout) :: self
        call self%destroy()
    end subroutine

    subroutine {short}_assign(self, other)
        class(toliman_{short}), intent(inout) :: self
        class(toliman_{short}), intent(in) :: other
        if (c_associated(self%handle) .or. c_associated(other%handle)) &
            error stop 'libtoliman: a toliman_{short} cannot be assigned'
    end subroutine

"""
        return text


def size_of(argument, place):
    return f"size({argument.name}, {place}, c_size_t)"


class Procedure:
    """A type-bound procedure that wraps one C function."""

    def __init__(self, layer, item, owner, binding, bound, creator):
        self.layer, self.model, self.item, self.owner, self.creator = layer, layer.model, item, owner, creator
        self.short, self.binding, self.bound = TYPES[owner], binding, bound
        self.names, self.optional_names, self.declared, self.locals = [], [], [], []
        self.before, self.actual = [], []
        self.info_filled, self.shapes = False, []
        self.array_extents = {extent for argument in item.arguments for extent in argument.extents}
        if bound:
            intent = "inout" if creator or not item.arguments[0].type.const else "in"
            self.names.append("self")
            self.declared.append(f"class(toliman_{self.short}), intent({intent}) :: self")
        for place, argument in enumerate(item.arguments):
            self.add_argument(argument, place)
        self.names += self.optional_names
        self.add_extents()

    def add_argument(self, argument, place):
        """Adds the dummy argument for one C argument, and the actual argument that is passed to C."""
        kind, name = argument.type, argument.name
        optional = ", optional" if argument.nullable else ""
        handle = self.layer.handle_of(argument)
        if place == 0 and self.bound and not self.creator:
            self.actual.append("self%handle")
        elif handle and kind.pointers == 2:
            self.locals.append("type(c_ptr) :: made")
            self.actual.append("made")
            if not self.creator:
                self.add_dummy(name, f"type(toliman_{TYPES[handle]}), intent(inout) :: {name}")
        elif handle:
            self.add_dummy(name, f"type(toliman_{TYPES[handle]}), intent(in) :: {name}")
            self.actual.append(f"{name}%handle")
        elif name in self.array_extents and not kind.pointers:
            self.locals.append(f"{base_type(self.model, kind)} :: of_{name}")
            self.actual.append(f"of_{name}")
        elif kind.base == "char":
            self.add_text(argument, optional)
        elif argument.extents:
            self.add_array(argument, optional)
        elif kind.pointers and kind.base == "void":
            self.add_dummy(name, f"type(c_ptr), intent(in) :: {name}")
            self.actual.append(name)
        elif self.model.kind(kind.base) is Callback:
            self.add_dummy(name, f"type(c_funptr), intent(in) :: {name}")
            self.actual.append(name)
        else:
            changed = "inout" if self.model.kind(kind.base) is Struct else "out"
            intent = "in" if kind.const or not kind.pointers else changed
            self.add_dummy(name, f"{base_type(self.model, kind)}, intent({intent}){optional} :: {name}")
            self.actual.append(name)

    def add_dummy(self, name, declaration, series=False):
        """Adds a dummy argument. Optional ones come last, except in a series of arrays (t, y, sigma), which keeps C's
        order: y and sigma have the same type, so that swapping them would go unnoticed."""
        (self.optional_names if ", optional" in declaration and not series else self.names).append(name)
        self.declared.append(declaration)

    def add_text(self, argument, optional):
        name = argument.name
        self.add_dummy(name, f"character(len=*), intent(in){optional} :: {name}")
        if argument.extents:
            self.before.append(f"of_{argument.extents[0]} = len({name}, c_size_t)")
            self.actual.append(name)
        elif optional:
            self.locals.append(f"character(kind=c_char), allocatable :: {name}_of_c(:)")
            self.before.append(f"if (present({name})) allocate ({name}_of_c, source=c_string({name}))")
            self.actual.append(f"{name}_of_c")
        else:
            self.actual.append(f"c_string({name})")

    def add_array(self, argument, optional):
        kind, name = argument.type, argument.name
        extents = list(reversed(argument.extents))
        intent = "in" if kind.const else "inout" if self.model.kind(kind.base) is Struct else "out"
        if kind.array:
            shape = f"({kind.array})"
        else:
            shape, optional = f"({', '.join(':' for _ in extents)})", optional + ", contiguous"
            self.shapes.append(f"{name}({', '.join(extents)})")
        place = self.item.arguments.index(argument)
        neighbours = self.item.arguments[max(place - 1, 0):place] + self.item.arguments[place + 1:place + 2]
        series = kind.const and argument.extents in (other.extents for other in neighbours if other.type.const)
        self.add_dummy(name, f"{base_type(self.model, kind)}, intent({intent}){optional} :: {name}{shape}", series)
        self.actual.append(name)

    def add_extents(self):
        """Sets C's extent arguments from the arrays' sizes, and adds the checks of all other extents."""
        plain = {argument.name: argument.type for argument in self.item.arguments if not argument.type.pointers}
        arrays = [argument for argument in self.item.arguments
                  if argument.extents and not argument.type.array and argument.type.base != "char"]
        sources = {}
        for extent in sorted(self.array_extents & set(plain), key=list(plain).index):
            has = [argument for argument in arrays if extent in argument.extents]
            sources[extent] = self.set_extent(extent, plain[extent], has) if has else None
        for argument in arrays:
            checks = []
            for place, extent in enumerate(reversed(argument.extents), 1):
                if sources.get(extent) is argument:
                    continue
                wanted = f"of_{extent}" if extent in plain else self.object_extent(extent)
                checks.append(f"if (.not. fits({size_of(argument, place)}, {wanted}, '{argument.name}', {place}, stat, "
                              "errmsg)) return")
            if argument.nullable and checks:
                checks = [f"if (present({argument.name})) then", *("    " + check for check in checks), "end if"]
            self.before += checks

    def set_extent(self, extent, kind, arrays):
        """Sets an extent argument from the first array present that has it. Returns the array that needs no check
        against the extent, if one is certain."""
        sizes = []
        for argument in arrays:
            size = size_of(argument, len(argument.extents) - argument.extents.index(extent))
            sizes.append(size if kind.base == "size_t" else f"int({size}, c_int64_t)")
            if not argument.nullable:
                self.before.append(f"of_{extent} = {sizes[-1]}")
                return argument
        self.before.append(f"of_{extent} = 0")
        for argument, size in reversed(list(zip(arrays, sizes))):
            self.before.append(f"if (present({argument.name})) of_{extent} = {size}")
        return arrays[0] if len(arrays) == 1 else None

    def object_extent(self, extent):
        """Returns an expression for an extent that is a number or a property of the object."""
        if extent.isdigit():
            return f"{extent}_c_size_t"
        if extent in ("rows", "cols"):
            return f"self%{extent}"
        source = self.layer.info_of(self.owner, extent)
        if source is None:
            raise SystemExit(f"tools/gen/shapes: {self.item.name}: {extent} is neither an argument nor a property of "
                             f"{self.owner}")
        if not self.info_filled:
            function, struct = source
            self.info_filled = True
            self.locals.append(f"type({struct}) :: info")
            self.before += [f"status = {function}(self%handle, out=info)", "if (status /= TOLIMAN_OK) then",
                            "    call conclude(status, stat, errmsg)", "    return", "end if"]
        return f"int(info%{extent}, c_size_t)"

    def after(self):
        """Returns the statements that store an object created by the call."""
        last = self.item.arguments[-1]
        handle = self.layer.handle_of(last)
        if not handle or last.type.pointers != 2:
            return []
        if last.type.const:
            raise SystemExit(f"{self.item.name}: returns a borrowed handle: define {self.short}_{self.binding} in "
                             "toliman.f90.in")
        target = "self" if self.creator else last.name
        lines = [f"call {target}%destroy()", f"{target}%handle = made"]
        if self.creator and self.layer.has_frames(handle):
            source = next((argument.name for argument in self.item.arguments
                           if self.layer.handle_of(argument) == "toliman_sim" and argument is not last), None)
            if source:
                lines += [f"self%rows = {source}%rows", f"self%cols = {source}%cols"]
            else:
                function, struct = self.layer.info_of(handle, "rows")
                self.locals.append(f"type({struct}) :: info")
                lines += [f"status = {function}(made, out=info)", "self%rows = int(info%rows, c_size_t)",
                          "self%cols = int(info%cols, c_size_t)"]
        return ["if (status == TOLIMAN_OK) then", *("    " + line for line in lines), "end if"]

    def write(self):
        item, name = self.item, f"{self.short}_{self.binding}"
        call = f"{item.name}({', '.join(self.actual)})"
        doc = flowing(first_sentence(item.doc) + ("" if not self.shapes else f" {', '.join(self.shapes)}."), 4)
        if not item.status:
            text = item.returns.base == "char"
            answer = "character(len=:), allocatable" if text else result(self.model, item.returns)
            call = f"toliman_text({call})" if text else call
            return (doc + wrapped(f"function {name}({', '.join(self.names)}) result(answer)", 4)
                    + listed(self.declared, 8) + f"        {answer} :: answer\n        answer = {call}\n"
                    "    end function\n")
        after = self.after()
        text = doc + wrapped(f"subroutine {name}({', '.join(self.names + ['stat', 'errmsg'])})", 4)
        text += listed(self.declared, 8) + listed(STATUS_ARGUMENTS, 8) + listed(self.locals, 8)
        if not self.before and not after:
            return text + wrapped(f"call conclude({call}, stat, errmsg)", 8) + "    end subroutine\n"
        text += "        integer(c_int32_t) :: status\n"
        text += "".join(wrapped(line, 8) for line in self.before) + wrapped(f"status = {call}", 8)
        text += "".join(f"        {line}\n" for line in after)
        return text + "        call conclude(status, stat, errmsg)\n    end subroutine\n"


def write(model, template):
    """Returns toliman.f90."""
    layer = Layer(model, template)
    parts = {"declarations": declarations(model) + "\n" + layer.types(),
             "procedures": layer.procedures + layer.lifecycle().rstrip("\n") + "\n"}
    return re.sub(r"^@(\w+)@$", lambda match: parts[match.group(1)].rstrip("\n") + "\n", template, flags=re.M)
