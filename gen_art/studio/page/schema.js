// Reading the JSON Schema of presets: which forms a value may have, which keys a mapping, and what a key is for.

export class Schema {
  #whole;

  constructor(whole) {
    this.#whole = whole;
    this.root = whole;
  }

  // The forms that a value of this schema may have, without references and without null.
  forms(schema) {
    if (schema === undefined || schema === true || schema === null) return [];
    if (schema.$ref !== undefined) return this.forms(this.#whole.$defs[schema.$ref.split("/").pop()]);
    const options = schema.anyOf ?? schema.oneOf ?? schema.allOf;
    if (options === undefined) return schema.type === "null" ? [] : [schema];
    return options.flatMap((option) => this.forms(option));
  }

  // name -> schema of the keys that a mapping of this schema may have
  keys(schema) {
    return Object.assign({}, ...this.forms(schema).map((form) => form.properties ?? {}));
  }

  // The schema of one key or index.
  child(schema, key) {
    for (const form of this.forms(schema)) {
      if (typeof key === "number" && form.items !== undefined) return form.items;
      if (form.properties?.[key] !== undefined) return form.properties[key];
    }
    for (const form of this.forms(schema)) {
      if (typeof form.additionalProperties === "object") return form.additionalProperties;
      if (typeof key === "number" && form.properties !== undefined) return schema;
    }
    return {};
  }

  // Whether its keys are names that the preset chooses.
  isNamed(schema) {
    return this.forms(schema).some((form) => typeof form.additionalProperties === "object");
  }

  words(schema) {
    if (schema?.description !== undefined) return schema.description;
    return this.forms(schema)[0]?.description ?? "";
  }

  unit(schema) {
    return schema?.unit ?? this.forms(schema).find((form) => form.unit !== undefined)?.unit ?? "";
  }

  choices(schema) {
    return [...new Set(this.forms(schema).flatMap((form) => form.enum ?? (form.const !== undefined ? [form.const] : [])))];
  }

  has(schema, type) {
    return this.forms(schema).some((form) => form.type === type || (Array.isArray(form.type) && form.type.includes(type)));
  }

  // [lowest, highest] that the schema allows, null where it says nothing
  limits(schema) {
    const form = this.forms(schema).find((one) => one.type === "number" || one.type === "integer") ?? {};
    return [form.minimum ?? form.exclusiveMinimum ?? null, form.maximum ?? form.exclusiveMaximum ?? null];
  }

  // A value to begin with.
  example(schema) {
    if (schema.default !== undefined && schema.default !== null) return schema.default;
    const choices = this.choices(schema);
    if (choices.length > 0) return choices[0];
    const form = this.forms(schema)[0] ?? {};
    if (form.default !== undefined && form.default !== null) return form.default;
    if (this.has(schema, "number") || this.has(schema, "integer")) {
      const [low, high] = this.limits(schema);
      return low !== null && low >= 0 ? Math.min(Math.max(1, low), high ?? Infinity) : 1;
    }
    if (form.type === "boolean") return true;
    if (form.type === "array") return form.minItems === 3 ? [0, 1, 0] : [];
    if (form.type === "object") {
      const required = form.required ?? [];
      return Object.fromEntries(required.map((key) => [key, this.example(form.properties[key])]));
    }
    return "";
  }
}
